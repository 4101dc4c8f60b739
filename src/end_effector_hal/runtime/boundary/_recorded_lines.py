"""Record the writes of a program to its lines, and whether the line arbiter can be reached."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from end_effector_hal.errors import ReportedError, WireError
from end_effector_hal.runtime.outputs import LineWriter
from end_effector_hal.vocabulary import NO_PART, LastWillStep, WrittenPart
from end_effector_hal.wires import now_us

from ._recorded_controller import Put
from ._records import ArbiterSeen, LinesWritten


class RecordedLines:
    """A line writer that passes every call on and records it."""

    def __init__(self, lines: LineWriter, put: Put) -> None:
        self._lines, self._put = lines, put
        self._there = True

    def levels(self) -> Mapping[str, bool]:
        """Return the level of every line."""
        try:
            levels = self._lines.levels()
        except WireError as error:
            self._lost(error)
            raise
        if not self._there:
            self._there = True
            self._put(ArbiterSeen(now_us(), there=True))
        return levels

    def recorded_part(self) -> str:
        """Return the name of the part that was gripped last; empty: none, or it has no name."""
        return self._lines.recorded_part()

    def declared_dead(self) -> bool:
        """Return whether the line arbiter has declared this program dead since the last call."""
        return self._lines.declared_dead()

    def ask(
        self,
        levels: Mapping[str, bool],
        will: Sequence[LastWillStep],
        *,
        drop: bool = False,
        part: WrittenPart = NO_PART,
    ) -> Callable[[], int]:
        """Begin to write levels and the last will."""
        at = now_us()
        asked = self._lines.ask(levels, will, drop=drop, part=part)

        def wait() -> int:
            error = ""
            try:
                return asked()
            except ReportedError as refused:
                error = str(refused)
                raise
            finally:
                steps = tuple(step.as_json() for step in will)
                self._put(LinesWritten(at, now_us() - at, dict(levels), steps, error))

        return wait

    def close(self, will: Sequence[LastWillStep]) -> None:
        """Close the connection in good order."""
        at = now_us()
        self._lines.close(will)
        self._put(LinesWritten(at, now_us() - at, {}, tuple(step.as_json() for step in will)))

    def _lost(self, error: Exception) -> None:
        if self._there:
            self._there = False
            self._put(ArbiterSeen(now_us(), there=False, why=str(error)))
