"""Segments of one run in a row: each begins where the one before it ends, or says what is missing."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from timed_automata import ExecutionSnapshot
from timed_automata.monitor import Objection

from ._load import ProgramTrace


@dataclass(frozen=True, slots=True)
class SegmentEnd:
    """Where a segment ends.

    Attributes:
        program, run, segment: of its header.
        complete: it was closed in good order.
        state: of its replayed controller, as JSON; None: it is not known.
        execution: of its automata, as the monitor followed them; None: they could not be followed to the end.
    """

    program: str
    run: str
    segment: int
    complete: bool
    state: dict[str, Any] | None
    execution: ExecutionSnapshot | None


class Chain:
    """A segment and the one that was recorded before it.

    Attributes:
        state: of the controller at the end of the segment before it, if nothing is missing between the two.
        objections: what there is to say against their order.
        notes: what is missing before it.
    """

    def __init__(self, trace: ProgramTrace, before: SegmentEnd | None) -> None:
        header = trace.header
        ours = before is not None and bool(header.run)
        ours = ours and before is not None and (before.program, before.run) == (header.program, header.run)
        self._before = before if ours else None
        self._header = header
        next_one = self._before is not None and self._before.segment + 1 == header.segment
        self._joined = self._before if next_one and header.gap is None else None
        self.state = self._joined.state if self._joined is not None else None
        self.objections = tuple(Objection(header.at, "no run", what) for what in self._faults())
        self.notes = tuple(self._missing(trace))

    def compare(self, recorded: ExecutionSnapshot) -> Iterator[Objection]:
        """The state with which the segment begins, and the one in which the monitor saw the segment before it end."""
        seen = self._joined.execution if self._joined is not None else None
        if seen is not None and replace(seen, at=recorded.at) != recorded:
            what = f"The recorded state is not where the segment before it ends: {_first_difference(seen, recorded)}."
            yield Objection(recorded.at, "no run", what)

    def _faults(self) -> Iterator[str]:
        before, segment = self._before, self._header.segment
        if before is None:
            return
        if before.segment >= segment:
            yield f"Segment {segment} was recorded after segment {before.segment}, but stands behind it."
        elif before.segment + 1 < segment:
            yield f"Between segment {before.segment} and this one, {segment}, others are missing."
        elif self._header.follows and not before.complete:
            yield f"Segment {before.segment} was closed in good order, and has no end now: something was cut off."

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


def _first_difference(seen: ExecutionSnapshot, recorded: ExecutionSnapshot) -> str:
    for what in ("locations", "variables", "zeros"):
        ours, theirs = getattr(seen, what), getattr(recorded, what)
        for name in sorted(ours.keys() | theirs.keys()):
            if ours.get(name) != theirs.get(name):
                return f"{what} {name}: {ours.get(name)}, recorded {theirs.get(name)}"
    return f"entered: {seen.entered}, recorded {recorded.entered}"
