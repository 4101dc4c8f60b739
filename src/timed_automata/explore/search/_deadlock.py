"""Deadlock: no transition is enabled, now or after any time that the invariant allows."""

from __future__ import annotations

from timed_automata.explore.states import PlannedMove, StateRecord
from timed_automata.explore.zones import (
    Constraint,
    Zone,
    constrained,
    constraints_of,
    down,
    everything,
    subtract,
)

MOST_DOUBTS = 20  # deadlocks in widened zones that turn out to be none: then a finer search is cheaper
Way = tuple[Constraint, ...]


def enabling(record: StateRecord, step: PlannedMove) -> tuple[Constraint, ...] | None:
    """What the clocks must satisfy at the instant of a move: guard, invariant here, invariant there."""
    _, target, move = step
    found = [*record.constraints(move.guard), *record.invariant]
    for clock, op, value in target.discrete.invariant if move.error is None else ():
        if clock not in move.resets:
            found += record.constraints(((clock, op, value),))  # type: ignore[arg-type]
        elif not (move.resets[clock] < value or (op == "<=" and move.resets[clock] == value)):
            return None
    return tuple(found)


def enabling_key(record: StateRecord, step: PlannedMove) -> object:
    """All that the above depends on, and whether time passes."""
    _, target, move = step
    return move.action, record.form, target.form if move.error is None else None


class Deadlocks:
    """Finds the valuations without a way on; what lets a state go on is computed once per discrete state."""

    def __init__(self) -> None:
        self._ways: dict[StateRecord, tuple[Way, ...]] = {}
        self._known: dict[object, Way | None] = {}

    def ways(self, record: StateRecord) -> tuple[Way, ...]:
        """Zones, as constraints, from which a transition is taken now or later."""
        found = self._ways.get(record)
        if found is None:
            ways = {way for step in record.steps if (way := self._way(record, step)) is not None}
            found = self._ways[record] = ((),) if () in ways else tuple(ways)
        return found

    def _way(self, record: StateRecord, step: PlannedMove) -> Way | None:
        key = enabling_key(record, step)
        if key not in self._known:
            needed, n = enabling(record, step), record.n
            zone = None if needed is None else constrained(everything(n), n, needed)
            if zone is not None and record.discrete.delays:
                zone = down(zone, n)
            self._known[key] = None if zone is None else tuple(constraints_of(zone, n))
        return self._known[key]

    def of(self, record: StateRecord, zone: Zone) -> list[Zone]:
        """The parts of a zone that are deadlocked, inside the invariant: widened zones may reach beyond it."""
        inside, n = constrained(zone, record.n, record.invariant), record.n
        left = [] if inside is None else [inside]
        for way in self.ways(record):
            left = [piece for part in left for piece in subtract(part, way, n)]
            if not left:
                break
        return left

    def part(self, record: StateRecord, zone: Zone) -> Zone | None:
        """A part of a zone that is deadlocked; None if there is none."""
        return next(iter(self.of(record, zone)), None)
