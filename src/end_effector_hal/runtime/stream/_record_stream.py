"""The socket of a program: its records go out, commands come in.

Rule 1: The program never waits. `put` hands records over; where the thread of the stream does not keep up, all readers
    lose their place and get a new state.
Rule 2: A reader begins with a state of the controller, which the program gives between two jobs, and gets every record
    from there on. One who does not read is dropped.
Rule 3: A command is asked by a thread of its own, and decided by the automata; the stream decides nothing.
Rule 4: Whatever happens to the socket ends no program: without it there is a warning in the log, and nothing else.
"""

from __future__ import annotations

import logging
import queue
import selectors
import socket
import threading
from collections.abc import Callable, Collection, Sequence
from contextlib import suppress
from pathlib import Path

from end_effector_hal.control import Answer
from end_effector_hal.errors import ReportedError, UsageError
from end_effector_hal.wires import Acceptor, listen, now_us

from ._protocol import (
    COMMAND_VALID_US,
    TOO_LATE,
    ProgramCommand,
    answer_line,
    read_command_message,
    record_line,
)
from ._readers import MOST_MESSAGES, StreamReader, StreamReaders

_log = logging.getLogger("end_effector_hal.runtime")
MOST_WAITING = 2_000
"""Records that wait for the thread of the stream."""
LOOK_S = 0.1
"""How often it looks for records while somebody reads, as often as a page shows them: each look costs the program."""
ALIVE_US = 400_000
AT_ONCE = 65_536
"""Bytes that are sent together; more would look as if a reader were behind."""
MOST_COMMANDS = 4
"""Of one reader, that wait to be decided."""
MOST_COMMANDS_OF_ALL = 32
"""Of all, those who have gone meanwhile among them."""
END_S = 1.0

Entry = tuple[str, int, object]
"""A record: its kind, its time and its content."""
Commander = Callable[[ProgramCommand], Answer]


class RecordStream:
    """Serves from `serve` to `close`. `put` and `begin` belong to one thread at a time, and never wait.

    Args:
        path: of the Unix socket: mode 0660, of the group of ``beside``.
        beside: the socket of the line arbiter, whose rights it gets.
        header: makes the first record for a reader.
        words: the commands that the program takes.
    """

    def __init__(
        self, path: Path, beside: Path, header: Callable[[int], object], words: Collection[str]
    ) -> None:
        self._path, self._beside, self._header, self._words = path, beside, header, frozenset(words)
        self.wants_state = False
        """Somebody waits for a state: `begin` is to be called."""
        self._active = False
        self._batches: queue.SimpleQueue[tuple[bool, Sequence[Entry]]] = queue.SimpleQueue()
        self._put_count = self._sent_count = 0  # each counted by one side only
        self._commands: queue.SimpleQueue[tuple[StreamReader, ProgramCommand] | None] = queue.SimpleQueue()
        self._answers: queue.SimpleQueue[tuple[StreamReader, bytes]] = queue.SimpleQueue()
        self._threads: list[threading.Thread] = []
        self._ended = False

    def serve(self, command: Commander, alive: Callable[[], bool], nudge: Callable[[], None]) -> None:
        """Make the socket, and begin; raises nothing.

        Args:
            command: asks the program, in a thread that may wait.
            alive: whether the program works.
            nudge: has the program do a job without an event, so that it sees :attr:`wants_state`; must not wait.
        """
        try:
            group = str(self._beside.stat().st_gid)
            self._acceptor = Acceptor(
                listen(self._path, group, whose="a program"), str(self._path), self._path
            )
            # sockets, for one that is closed is never written to: its number may be somebody else's by then
            self._wake_read, self._wake = socket.socketpair()
        except (ReportedError, OSError) as error:
            _log.warning("no page can show this program: %s", error)
            return
        self._wake.setblocking(False)
        self._command, self._alive, self._nudge = command, alive, nudge
        try:
            for name, run in (("stream commands", self._ask), ("stream", self._run)):
                thread = threading.Thread(target=run, name=name, daemon=True)
                thread.start()
                self._threads.append(thread)
        except RuntimeError as error:  # the system gives no thread
            _log.warning("no page can show this program: %s", error)
            self._acceptor.close()
            self.close()

    def put(self, batch: Sequence[Entry]) -> None:
        """Have records sent; returns at once."""
        if not self._active or not batch:
            return
        if self._put_count - self._sent_count + len(batch) > MOST_WAITING:
            self._active = False  # until everybody got a new state
            self._batches.put((False, ()))
            return
        self._put_count += len(batch)
        self._batches.put((False, batch))

    def begin(self, first: Sequence[Entry]) -> None:
        """Go on from here, with these records after the header; returns at once."""
        self.wants_state, self._active = False, True
        self._batches.put((True, first))

    def close(self) -> None:
        """End all connections, and remove the socket."""
        if not self._threads:
            return
        self._ended = True
        self._commands.put(None)
        self._ring()
        for thread in self._threads:
            if thread is not threading.current_thread():
                thread.join(END_S)
        self._wake.close()

    def _ring(self) -> None:
        with suppress(OSError):
            self._wake.send(b"x")

    # From here on: in the thread of the stream.

    def _run(self) -> None:
        selector = selectors.DefaultSelector()
        readers = StreamReaders(selector)
        try:
            selector.register(self._acceptor.listener, selectors.EVENT_READ)
            selector.register(self._wake_read, selectors.EVENT_READ)
            self._loop(selector, readers)
        except Exception:  # noqa: BLE001 it ends no program
            _log.exception("the stream of a program has ended")
        finally:
            self._active = False
            for reader in readers:
                readers.drop(reader)
            selector.close()
            self._acceptor.close()
            self._wake_read.close()

    def _loop(self, selector: selectors.BaseSelector, readers: StreamReaders) -> None:
        alive_at = 0
        while not self._ended:
            for key, events in selector.select(LOOK_S if len(readers) else None):
                if isinstance(key.data, StreamReader):
                    self._talk(readers, key.data, events)
                elif key.fileobj is self._acceptor.listener:
                    readers.accept(self._acceptor)
                else:
                    self._wake_read.recv(100)
            sent = self._send_all(readers)
            at = now_us()
            if sent:
                alive_at = at
            elif at - alive_at >= ALIVE_US and len(readers) and self._alive():
                alive_at = at
                self._send(readers, record_line("alive", at, {}))
            if not len(readers):
                self._active = False
            if any(not reader.follows for reader in readers) and not self.wants_state:
                self.wants_state = True
                self._nudge()

    def _talk(self, readers: StreamReaders, reader: StreamReader, events: int) -> None:
        if events & selectors.EVENT_WRITE:
            readers.send(reader)
        if not events & selectors.EVENT_READ or reader.sock.fileno() < 0:
            return
        lines, goes_on = reader.receive()
        if reader.floods(len(lines), now_us()):
            too_many = Answer(False, f"More than {MOST_MESSAGES} messages came within a second.")
            readers.put(reader, answer_line(None, too_many))
            readers.drop(reader)
            return
        for line in lines:
            try:
                message = read_command_message(line)
            except UsageError as error:
                readers.put(reader, answer_line(None, Answer(False, str(error))))
                continue
            if reader.commands_waiting >= MOST_COMMANDS or self._commands.qsize() >= MOST_COMMANDS_OF_ALL:
                busy = Answer(False, "Too many commands are waiting: this one is not executed.")
                readers.put(reader, answer_line(message.id, busy))
                continue
            reader.commands_waiting += 1
            self._commands.put((reader, message))
        if not goes_on:
            readers.drop(reader)

    def _send_all(self, readers: StreamReaders) -> bool:
        sent = False
        while not self._answers.empty():
            reader, line = self._answers.get()
            reader.commands_waiting -= 1
            readers.put(reader, line)
        following = bytearray()  # of several batches: one call of the system for each reader
        while not self._batches.empty():
            begins, batch = self._batches.get()
            self._sent_count += 0 if begins else len(batch)
            sent = True
            lost = not batch and not begins
            if following and (begins or lost or len(following) > AT_ONCE):
                self._send(readers, bytes(following))
                following.clear()
            if lost:
                for reader in readers:
                    reader.follows = False
                continue
            data = b"".join(record_line(*entry) for entry in batch)
            if begins:
                at = now_us()
                data = record_line("header", at, self._header(at)) + data
                for reader in readers:
                    if not reader.follows:
                        reader.follows = True
                        readers.put(reader, data)
            else:
                following += data
        if following:
            self._send(readers, bytes(following))
        return sent

    def _send(self, readers: StreamReaders, data: bytes) -> None:
        for reader in readers:
            if reader.follows:
                readers.put(reader, data)

    # In the thread that asks.

    def _ask(self) -> None:
        while (entry := self._commands.get()) is not None:
            reader, message = entry
            try:
                answer = self._decide(message)
            except Exception:  # noqa: BLE001 it ends no program
                _log.exception("a command could not be asked")
                answer = Answer(False, "The program could not be asked.", decided=False)
            self._answers.put((reader, answer_line(message.id, answer)))
            self._ring()

    def _decide(self, message: ProgramCommand) -> Answer:
        if message.command not in self._words:
            return Answer(
                False, f"There is no such command here; there are {', '.join(sorted(self._words))}."
            )
        at = now_us()
        if at > message.until_us:
            return Answer(False, TOO_LATE)
        if message.until_us > at + COMMAND_VALID_US:
            return Answer(False, "The command may wait for too long and was not executed: its time is wrong.")
        return self._command(message)
