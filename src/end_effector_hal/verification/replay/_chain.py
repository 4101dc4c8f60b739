"""Check consecutive segments of one run: each must begin where the previous one ends, or report a gap."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from end_effector_hal.description import Description
from timed_automata import ExecutionSnapshot
from timed_automata.monitor import Objection

from ._load import ProgramTrace
from ._written_lines import WrittenLines


@dataclass(frozen=True, slots=True)
class SegmentEnd:
    """The end of a segment.

    Attributes:
        run, segment: from its header.
        complete: whether it was closed in good order.
        state: state of its replayed controller, as JSON; None: unknown.
        execution: state of its automata, as the monitor followed them; None: they could not be followed to the end.
        lines: the writes to its lines, and the deactivations that are still owed.
        path: path of its file.
    """

    run: str
    segment: int
    complete: bool
    state: dict[str, Any] | None
    execution: ExecutionSnapshot | None
    lines: WrittenLines
    path: Path


class Chain:
    """A segment and the one that was recorded before it.

    Attributes:
        state: state of the controller at the end of the previous segment, if nothing is missing between the two.
        objections: faults in the order of the two.
        notes: sentences about missing data before the segment.
    """

    def __init__(self, trace: ProgramTrace, before: SegmentEnd | None) -> None:
        header = trace.header
        self._before_in_folder, self._path = before, trace.file.path
        ours = before is not None and before.run == header.run
        self._before = before if ours else None
        self._header = header
        next_one = self._before is not None and self._before.segment + 1 == header.segment
        self._joined = self._before if next_one and header.gap is None else None
        self.state = self._joined.state if self._joined is not None else None
        self.objections = tuple(Objection(header.at, "no run", what) for what in self._faults())
        self.notes = tuple(self._missing(trace))

    def lines(self, tool: Description) -> WrittenLines:
        """Return the known state of the lines at the beginning of the segment."""
        if self._joined is not None and self._joined.complete:
            return self._joined.lines.copied()
        return WrittenLines(tool)

    def compare(self, recorded: ExecutionSnapshot) -> Iterator[Objection]:
        """Yield an objection if the segment begins in another state than that in which the previous one ended."""
        seen = self._joined.execution if self._joined is not None else None
        if seen is not None and replace(seen, at=recorded.at) != recorded:
            what = f"The recorded state is not the end of the segment before it: {_first_difference(seen, recorded)}."
            yield Objection(recorded.at, "no run", what)

    def _faults(self) -> Iterator[str]:
        before, segment = self._before, self._header.segment
        if before is None:
            yield from self._faults_of_run()
            return
        if before.segment >= segment:
            yield f"Segment {segment} comes after segment {before.segment}, but its number is not higher."
        elif before.segment + 1 < segment:
            yield f"Between segment {before.segment} and this one, {segment}, others are missing."
        elif self._header.follows and not before.complete:
            yield f"Segment {before.segment} was closed in good order, but its end is missing now: it was cut off."
        elif before.complete and self._joined is not None and not self._header.follows:
            yield f"Segment {before.segment} was closed in good order, but this one is not its successor."

    def _faults_of_run(self) -> Iterator[str]:
        """Yield a fault if a segment that is not the first directly follows a trace of another run."""
        other, header = self._before_in_folder, self._header
        if other is None or header.segment <= 1:
            return
        if _number(other.path) + 1 == _number(self._path):
            yield f"This is segment {header.segment} of a run, and the trace right before it is of another run."

    def _missing(self, trace: ProgramTrace) -> Iterator[str]:
        header = self._header
        if header.gap is not None:
            since = trace.seconds(header.gap.since)
            yield (
                f"Before this segment {header.gap.records} records were not written, from {-since:.3f} s before it on: "
                f"{header.gap.why}."
            )
        if header.segment > 1 and self._before is None:
            yield f"This is segment {header.segment}: it is judged from the state with which it begins."


def _number(path: Path) -> int:
    """Return the number of a file ``NAME-N``; ``NAME`` alone is number 1."""
    number = path.stem.rpartition("-")[2]
    return int(number) if number.isdecimal() and len(number) < 10 else 1


def _first_difference(seen: ExecutionSnapshot, recorded: ExecutionSnapshot) -> str:
    for what in ("locations", "variables", "zeros"):
        ours, theirs = getattr(seen, what), getattr(recorded, what)
        for name in sorted(ours.keys() | theirs.keys()):
            if ours.get(name) != theirs.get(name):
                return f"{what} {name}: {ours.get(name)}, recorded {theirs.get(name)}"
    return f"entered: {seen.entered}, recorded {recorded.entered}"
