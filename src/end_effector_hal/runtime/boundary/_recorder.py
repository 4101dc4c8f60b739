"""The recording of a program: wrappers around its controller and its lines, and the segments of its trace."""

from __future__ import annotations

import logging
from collections.abc import Callable

from end_effector_hal.control import Controller
from end_effector_hal.description import Description
from end_effector_hal.recording import TraceWriter
from end_effector_hal.runtime._error_text import error_text, sendable
from end_effector_hal.runtime.outputs import LineWriter
from end_effector_hal.sensing import FrameJudge
from end_effector_hal.wires import now_us
from timed_automata import Network

from ._recorded_controller import AnyController, RecordedController
from ._recorded_lines import RecordedLines
from ._records import STATE

_log = logging.getLogger("end_effector_hal.runtime")


class Recorder:
    """Wraps the controller and the lines of a program; without a writer it leaves them as they are.

    A failing recording reaches the program as :attr:`trouble` only.
    """

    def __init__(self, writer: TraceWriter | None = None) -> None:
        self._writer = writer
        self._controller: RecordedController | None = None
        self._defect = ""

    @property
    def trouble(self) -> str:
        """Why what happens now is not recorded, a sentence; empty: it is, or nothing is to be recorded."""
        return sendable(self._defect or (self._writer.trouble if self._writer is not None else ""))

    def attend(self, on_trouble: Callable[[], None]) -> None:
        """Have ``on_trouble`` called when :attr:`trouble` has changed, in any thread; it must not wait."""
        if self._writer is not None:
            self._writer.on_trouble = on_trouble

    def controller(
        self, description: Description, network: Network, program: str, judge: FrameJudge | None = None
    ) -> AnyController:
        """A new controller."""
        if self._writer is None:
            return Controller(description, network, program, judge=judge)
        self._controller = RecordedController(description, network, program, self._writer.put, judge)
        self._controller.snapshot()  # the first one takes milliseconds: better now than in a grip
        return self._controller

    def lines(self, lines: LineWriter) -> LineWriter:
        """Lines to write to."""
        if self._writer is None:
            return lines
        return RecordedLines(lines, self._writer.put)

    def flush(self) -> None:
        """Write what was recorded, and begin the next segment if it is time; never waits.

        The program calls it between its jobs, so that it costs no reaction.
        """
        if self._writer is None:
            return
        self._writer.flush()
        if not self._writer.wants_state or self._defect:
            return
        try:
            self._begin_segment(self._writer)
        except Exception as error:  # noqa: BLE001 a defect of the recorder ends no program
            _log.exception("no further segment of a trace can be begun")
            self._defect = f"The trace has come to its end: {error_text(error)}"

    def close(self) -> None:
        """Nothing more comes; waits two seconds at most for the disk."""
        if self._writer is not None:
            self._writer.close()

    def _begin_segment(self, writer: TraceWriter) -> None:
        snapshot = self._controller.snapshot() if self._controller is not None else None
        if snapshot is None:  # it will begin with its start
            writer.begin(now_us(), ())
        else:
            writer.begin(snapshot.at, ((STATE, snapshot.at, snapshot),))


NULL_RECORDER = Recorder()
"""Records nothing."""
