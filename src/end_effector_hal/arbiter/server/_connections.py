"""All connections of the arbiter: their messages, how many there may be, and how long they may be silent."""

from __future__ import annotations

import logging
import selectors
import socket
import struct
from collections import Counter
from collections.abc import Iterator, Mapping

from end_effector_hal.arbiter.protocol import write_message
from end_effector_hal.arbiter.rules import Session, process_words
from end_effector_hal.vocabulary import LONGEST_MESSAGE
from end_effector_hal.wires import now_us, program_name
from end_effector_hal.wires.rpc import Listener


class Connection:
    """Reads without waiting, one message after the other, and no further than `receive` is called.

    Args:
        sock: accepted; it is closed by `close`.
        at: now, µs.
    """

    def __init__(self, sock: socket.socket, at: int) -> None:
        sock.setblocking(False)
        self.sock = sock
        self.pid, self.uid, _ = struct.unpack(
            "3i", sock.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, 12)
        )
        self.program = program_name(self.pid) if self.pid else ""
        self.session: Session | None = None
        self.sends_predicates = False
        self.heard_at = at
        self.ended = False
        """The other end is closed; what it sent before is still to be answered."""
        self._rest = b""

    @property
    def process(self) -> str:
        """The process at the other end, for people."""
        return process_words(self.pid, self.program)

    @property
    def rank(self) -> int:
        """The order of answers: what the sensors prove was sent before any write that follows from it."""
        return 0 if self.sends_predicates else 1 if self.session else 2

    @property
    def waits(self) -> bool:
        """Whether a whole message was received and is not fetched yet."""
        return b"\n" in self._rest

    @property
    def overlong(self) -> bool:
        """Whether more came than any message is long."""
        return not self.waits and len(self._rest) > LONGEST_MESSAGE

    def receive(self) -> None:
        """Read what is there; nothing while messages wait, so that a flood fills the buffers of its sender."""
        if self.waits or self.ended:
            return
        try:
            data = self.sock.recv(LONGEST_MESSAGE)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        self.ended, self._rest = not data, self._rest + data

    def next_message(self) -> bytes | None:
        """Fetch the next message; None: there is no whole one."""
        line, newline, rest = self._rest.partition(b"\n")
        if not newline:
            return None
        self._rest = rest
        return line

    def send(self, message: Mapping[str, object]) -> bool:
        """Returns whether the whole message went out; a client that does not read its replies is treated as dead."""
        data = write_message(message)
        try:
            return self.sock.send(data) == len(data)
        except OSError:
            return False

    @property
    def closed(self) -> bool:
        return self.sock.fileno() < 0

    def close(self) -> None:
        self.sock.close()


_log = logging.getLogger("end_effector_hal.arbiter")
MOST_STRANGERS = 32
"""Connections that neither write lines nor send predicates; there is one sender, and at most one writer per line."""
IDLE_US = 10_000_000
ACCEPTED = 8
MESSAGES = 8
"""In one round, from one connection; a quarter of that from one that neither writes nor sends predicates."""


class Connections:
    """Registered with a selector, which reports those that have something to read.

    Args:
        listener: the arbiter's socket, which does not block.
        selector: gets every connection, with itself as its data.
    """

    def __init__(self, listener: Listener, selector: selectors.BaseSelector) -> None:
        self._listener, self._selector = listener, selector
        self._open: dict[Connection, None] = {}  # in the order in which they came
        selector.register(listener, selectors.EVENT_READ)

    def __iter__(self) -> Iterator[Connection]:
        return iter(list(self._open))

    def accept(self) -> list[Connection]:
        """Accept those that wait; returns connections to be closed for them: the oldest of the user that has most."""
        for _ in range(ACCEPTED):
            if (sock := self._listener.accept()) is None:
                break
            try:
                connection = Connection(sock, now_us())
            except OSError as error:
                _log.warning("a client could not be accepted: %s", error)
                sock.close()
                break
            self._selector.register(connection.sock, selectors.EVENT_READ, connection)
            self._open[connection] = None
        strangers, surplus = [each for each in self._open if each.rank == 2], list[Connection]()
        while len(strangers) > MOST_STRANGERS:
            ((uid, _),) = Counter(each.uid for each in strangers).most_common(1)
            surplus.append(next(each for each in strangers if each.uid == uid))
            strangers.remove(surplus[-1])
        return surplus

    def idle(self, at: int) -> list[Connection]:
        """Those that were silent for too long; connections that write lines have a lease instead."""
        return [each for each in self._open if not each.session and at - each.heard_at >= IDLE_US]

    def due(self) -> int | None:
        """When the next one will have been silent for too long."""
        return min((each.heard_at + IDLE_US for each in self._open if not each.session), default=None)

    def round(self, ready: set[Connection]) -> list[Connection]:
        """Those that have messages, in the order in which they are answered."""
        waiting = [each for each in self._open if each in ready or each.waits]
        return sorted(waiting, key=lambda each: each.rank)

    @property
    def wait(self) -> bool:
        """Whether messages were received that are not fetched yet."""
        return any(each.waits for each in self._open)

    def drop(self, connection: Connection) -> None:
        """Close it."""
        self._selector.unregister(connection.sock)
        connection.close()
        del self._open[connection]

    def close(self) -> None:
        """All of them, and the listener."""
        for connection in self:
            self.drop(connection)
        self._listener.close()
