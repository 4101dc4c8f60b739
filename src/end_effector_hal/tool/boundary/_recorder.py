"""What a unit hands to its trace."""

from __future__ import annotations

from end_effector_hal.automata import Network
from end_effector_hal.control import Controller
from end_effector_hal.description import Description
from end_effector_hal.trace import TraceWriter

from .._outputs import LineWriter
from ._recorded_controller import RecordedController
from ._recorded_lines import RecordedLines


class Recorder:
    """Gives a unit a controller and lines that are recorded; without a writer, plain ones."""

    def __init__(self, writer: TraceWriter | None = None) -> None:
        self._writer = writer

    def controller(self, description: Description, network: Network, program: str) -> Controller:
        """A new controller."""
        if self._writer is None:
            return Controller(description, network, program)
        return RecordedController(description, network, program, self._writer.put)

    def lines(self, lines: LineWriter) -> LineWriter:
        """Lines to write to."""
        if self._writer is None:
            return lines
        return RecordedLines(lines, self._writer.put)

    def settle(self) -> None:
        """What was to be done is done: now is the time to write."""
        if self._writer is not None:
            self._writer.flush()

    def close(self) -> None:
        """Nothing more comes."""
        if self._writer is not None:
            self._writer.close()


NOBODY = Recorder()
"""Records nothing."""
