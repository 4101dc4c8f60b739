"""The socket of a testbench: a page sees what is wrong, and chooses something else.

Rule 1: The bench never waits for it: a thread of its own, bounded messages, and who does not read is dropped.
Rule 2: A scenario is judged by the testbench alone, in its own words; what came too late changes nothing.
Rule 3: Whatever happens to the socket ends no testbench: without it there is a warning, and no page has a panel.
"""

from __future__ import annotations

import logging
import selectors
import threading
from collections.abc import Callable

from end_effector_hal.description import Description, socket_path
from end_effector_hal.errors import ReportedError, UsageError
from end_effector_hal.faults import (
    ALIVE_US,
    LONGEST,
    VALID_US,
    FaultRequest,
    TestbenchHeader,
    TestbenchScenario,
    answer_line,
    message_line,
    read_fault_request,
    socket_of_testbench,
)
from end_effector_hal.recording import content_hash
from end_effector_hal.runtime.stream import StreamReader, StreamReaders
from end_effector_hal.wires import Acceptor, listen, now_us
from end_effector_lab.testbench._possible import offered_faults
from end_effector_lab.testbench._testbench import Testbench

_log = logging.getLogger("end_effector_lab.testbench")
LOOK_S = 0.1
MOST_AT_ONCE = 4
"""Requests of one reader in one round: choosing holds the bench up."""


class FaultServer:
    """Serves from `start` to `close`.

    Args:
        description: of the tool.
        bench: which runs.
        chosen: is told each scenario that was chosen here, in the thread of this server.
    """

    def __init__(self, description: Description, bench: Testbench, chosen: Callable[[str], None]) -> None:
        self._description, self._bench, self._chosen = description, bench, chosen
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        """Make the socket, mode 0660, of the group of the line arbiter's if that is there; raises nothing."""
        try:
            self._header = message_line(
                TestbenchHeader(
                    self._description.name,
                    content_hash(self._description),
                    tuple(offered_faults(self._description)),
                )
            )
            self._path = socket_of_testbench(self._description)
            arbiter = socket_path(self._description)
            group = str(arbiter.stat().st_gid) if arbiter.exists() else None
            listener = listen(self._path, group, whose="the testbench")
            self._acceptor = Acceptor(listener, str(self._path), self._path)
        except (ReportedError, OSError) as error:
            _log.warning("no page can choose faults: %s", error)
            return
        self._thread = threading.Thread(target=self._run, name="faults", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End all connections, and remove the socket."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join()

    def __enter__(self) -> FaultServer:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _run(self) -> None:
        selector = selectors.DefaultSelector()
        readers = StreamReaders(selector, LONGEST)
        try:
            selector.register(self._acceptor.listener, selectors.EVENT_READ)
            self._loop(selector, readers)
        except Exception:  # noqa: BLE001 it ends no testbench
            _log.exception("the socket for faults has ended")
        finally:
            for reader in readers:
                readers.drop(reader)
            selector.close()
            self._acceptor.close()

    def _loop(self, selector: selectors.BaseSelector, readers: StreamReaders) -> None:
        said, said_at = "", 0
        while not self._stop.is_set():
            for key, events in selector.select(LOOK_S):
                if isinstance(key.data, StreamReader):
                    self._talk(readers, key.data, events)
                else:
                    readers.accept(self._acceptor)
            scenario, at = self._bench.scenario, now_us()
            line = message_line(TestbenchScenario(scenario))
            due = scenario != said or at - said_at >= ALIVE_US
            for reader in readers:
                if not reader.follows:
                    reader.follows = True
                    readers.put(reader, self._header + line)
                elif due:
                    readers.put(reader, line)
            if due:
                said, said_at = scenario, at

    def _talk(self, readers: StreamReaders, reader: StreamReader, events: int) -> None:
        if events & selectors.EVENT_WRITE:
            readers.send(reader)
        if not events & selectors.EVENT_READ or reader.sock.fileno() < 0:
            return
        lines, goes_on = reader.receive()
        for count, line in enumerate(lines):
            readers.put(reader, self._answer(line, busy=count >= MOST_AT_ONCE))
        if not goes_on:
            readers.drop(reader)

    def _answer(self, line: bytes, *, busy: bool) -> bytes:
        number = None
        try:
            request = read_fault_request(line)
            number = request.id
            if busy:
                raise UsageError("Too many requests at once: this one is not executed.")
            self._obey(request)
        except UsageError as error:
            return answer_line(number, accepted=False, reason=str(error))
        return answer_line(number, accepted=True)

    def _obey(self, request: FaultRequest) -> None:
        at = now_us()
        if at > request.until_us:
            raise UsageError("The request came too late: nothing was changed.")
        if request.until_us > at + VALID_US:
            raise UsageError("until_us is too far ahead: check the clock. Nothing was changed.")
        if not request.scenario.isprintable():
            raise UsageError(f"scenario {request.scenario!r} has characters that cannot be printed.")
        if request.word == "check":
            self._bench.check(request.scenario)
        else:
            self._bench.choose(request.scenario)
            self._chosen(request.scenario)
