"""The recorder of a program: it wraps its controller and its lines, and feeds its trace and its stream."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping

from end_effector_hal.control import Controller, Status
from end_effector_hal.description import Description
from end_effector_hal.recording import TraceWriter
from end_effector_hal.runtime._error_text import error_text, sendable
from end_effector_hal.runtime.outputs import LineWriter
from end_effector_hal.runtime.stream import PUBLISHED, READINGS, Commander, Entry, RecordStream
from end_effector_hal.sensing import JudgedReadings
from end_effector_hal.wires import now_us
from end_effector_hal.wires.sensors import SensorHealth
from timed_automata import Network

from ._recorded_controller import AnyController, Put, RecordedController
from ._recorded_lines import RecordedLines
from ._records import Published, entry_of

Observer = Callable[[str, int, object], None]
"""A function that is called with each record of a program: the kind, the time (µs), the content. It runs in the
program's threads, and must not wait.
"""

_log = logging.getLogger("end_effector_hal.runtime")


class Recorder:
    """Wraps the controller and the lines of a program; without writer, stream and observer they stay unwrapped.

    A failed recording has no effect on the program except :attr:`trouble`.

    Args:
        writer: writes the trace; None: nothing is recorded.
        stream: sends the records to clients; None: no client can read them.
        observe: called with each record as well; an exception is logged once and ends these calls.
    """

    def __init__(
        self,
        writer: TraceWriter | None = None,
        stream: RecordStream | None = None,
        observe: Observer | None = None,
    ) -> None:
        self._writer, self._stream, self._observe = writer, stream, observe
        self._records: list[object] = []
        """Records that are kept until `flush`, after the line was written, because they are not needed before."""
        self._controller: RecordedController | None = None
        self._published: Published | None = None
        self._readings: JudgedReadings | None = None
        self._defect = ""

    @property
    def trouble(self) -> str:
        """A sentence why current events are not recorded; empty: they are, or recording is off."""
        trouble = self._defect or (self._writer.trouble if self._writer is not None else "")
        return sendable(trouble) if trouble else ""

    def attend(self, on_trouble: Callable[[], None]) -> None:
        """Call ``on_trouble`` when :attr:`trouble` changes; the call may come from any thread and must not wait."""
        if self._writer is not None:
            self._writer.on_trouble = on_trouble

    def serve(
        self,
        command: Commander,
        alive: Callable[[], bool],
        nudge: Callable[[], None],
        health: Callable[[], SensorHealth],
    ) -> None:
        """Serve the stream from now on; see `RecordStream.serve`."""
        if self._stream is not None:
            self._stream.serve(command, alive, nudge, health)

    @property
    def is_read(self) -> bool:
        """Whether a client reads the stream."""
        return self._stream is not None and self._stream.is_read

    def controller(self, description: Description, network: Network) -> AnyController:
        """Return a new controller, wrapped if anything is recorded."""
        if (put := self._put) is None:
            return Controller(description, network)
        self._controller = RecordedController(description, network, put)
        self._controller.snapshot()  # the first one takes milliseconds: better now than in a grip
        return self._controller

    def lines(self, lines: LineWriter) -> LineWriter:
        """Return the line writer, wrapped if anything is recorded."""
        return lines if (put := self._put) is None else RecordedLines(lines, put)

    def published(self, status: Status, refused: Mapping[str, str]) -> None:
        """Record a published status; ``refused``: reasons for commands that are refused before they reach the
        automata.
        """
        if self._stream is not None:
            self._published = Published(status.at, status, refused)
            self._records.append(self._published)

    def readings(self, readings: JudgedReadings) -> None:
        """Send what the sensors read to the clients of the stream."""
        if self._stream is not None:
            self._readings = readings
            self._records.append(readings)

    def flush(self) -> None:
        """Pass on the records, and begin the next segment if it is time; never waits.

        The program calls this between its jobs, so that no reaction is delayed.
        """
        self._pass_on()
        if self._stream is not None and self._stream.wants_state:
            self._stream.begin(self._state_now())
        if self._writer is None or not self._writer.wants_state or self._defect:
            return
        try:
            self._begin_segment(self._writer)
        except Exception as error:  # noqa: BLE001 a defect of the recorder ends no program
            _log.exception("no further segment of a trace can be begun")
            self._defect = f"The trace has come to its end: {error_text(error)}"

    def close(self) -> None:
        """Pass on the last records and close; waits two seconds at most for the disk."""
        self._pass_on()
        if self._stream is not None:
            self._stream.close()
        if self._writer is not None:
            self._writer.close()

    @property
    def _put(self) -> Put | None:
        """The function that stores a record; None: nothing is recorded."""
        if self._observe is not None:
            return self._put_and_show
        return self._records.append if self._writer is not None or self._stream is not None else None

    def _put_and_show(self, record: object) -> None:
        self._records.append(record)
        if self._observe is None:
            return
        try:
            self._observe(*entry_of(record))
        except Exception:  # noqa: BLE001 who looks on ends no program
            _log.exception("the observer of a program failed")
            self._observe = None

    def _pass_on(self) -> None:
        entries = list(map(entry_of, self._records))
        del self._records[: len(entries)]  # records that another thread has added since then stay
        if self._stream is not None:
            self._stream.put(entries)
        if self._writer is not None:
            self._writer.put([entry for entry in entries if entry[0] not in (PUBLISHED, READINGS)])

    def _begin_segment(self, writer: TraceWriter) -> None:
        snapshot = self._controller.snapshot() if self._controller is not None else None
        if snapshot is None:  # it will begin with its start
            writer.begin(now_us(), ())
        else:
            writer.begin(snapshot.at, (entry_of(snapshot),))

    def _state_now(self) -> list[Entry]:
        """Return the current state of the program, for a client that connects now."""
        records: list[object] = [self._published, self._readings]
        try:
            if self._controller is not None:
                records.insert(0, self._controller.snapshot())
        except Exception:  # noqa: BLE001 a defect of the recorder ends no program
            _log.exception("the live page cannot show the state of the program")
        return [entry_of(record) for record in records if record is not None]


NULL_RECORDER = Recorder()
"""Records nothing."""
