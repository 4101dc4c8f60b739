"""Finds deadlocks: no transition is enabled, now or after any delay that the invariant allows."""

from __future__ import annotations

from timed_automata.explore.states import StateRecord
from timed_automata.explore.states._symbolic import PlannedMove
from timed_automata.explore.zones import Zone, constrained, constraints_of, included, subtract
from timed_automata.explore.zones._zone import Constraint, down, everything

MOST_DOUBTS = 20  # deadlocks in widened zones that turn out to be none: then a finer search is cheaper
Way = tuple[Constraint, ...]


class Deadlocks:
    """Finds deadlocked valuations; the conditions to leave a state are computed once per discrete state."""

    def __init__(self) -> None:
        self._ways: dict[StateRecord, tuple[Way, ...]] = {}
        self._known: dict[object, tuple[Way | None, bool]] = {}

    def forget(self) -> None:
        """Drop cached data about records."""
        self._ways.clear()

    def ruled_out(self, record: StateRecord) -> bool:
        """Return whether one transition is enabled, now or later, from every valuation that the invariant allows.

        Sufficient, not necessary: several transitions together may cover all valuations.
        """
        return any(self._way(record, step)[1] for step in record.steps)

    def ways(self, record: StateRecord) -> tuple[Way, ...]:
        """Return zones, as constraints, from which a transition is taken now or later."""
        found = self._ways.get(record)
        if found is None:
            ways = {way for step in record.steps if (way := self._way(record, step)[0]) is not None}
            found = self._ways[record] = ((),) if () in ways else tuple(ways)
        return found

    def _way(self, record: StateRecord, step: PlannedMove) -> tuple[Way | None, bool]:
        """Return the zone from which one move is taken now or later, and whether it covers the whole invariant."""
        _, target, move = step
        key = move.action, record.form, target.form if move.error is None else None
        found = self._known.get(key)
        if found is None:
            n, needed = record.n, _enabling(record, step)
            zone = None if needed is None else constrained(everything(n), n, needed)
            inside = constrained(everything(n), n, record.invariant)
            if zone is None:
                found = None, inside is None
            else:
                before = down(zone, n) if record.discrete.delays else zone
                found = tuple(constraints_of(before, n)), inside is None or included(inside, before)
            self._known[key] = found
        return found

    def of(self, record: StateRecord, zone: Zone) -> list[Zone]:
        """Return the deadlocked parts of a zone inside the invariant, which widened zones may exceed."""
        inside, n = constrained(zone, record.n, record.invariant), record.n
        left = [] if inside is None else [inside]
        for way in self.ways(record):
            left = [piece for part in left for piece in subtract(part, way, n)]
            if not left:
                break
        return left

    def part(self, record: StateRecord, zone: Zone) -> Zone | None:
        """Return a deadlocked part of a zone, or None if there is none."""
        return next(iter(self.of(record, zone)), None)


def _enabling(record: StateRecord, step: PlannedMove) -> tuple[Constraint, ...] | None:
    """Return the clock constraints at the instant of a move: guard, invariant of the source and of the target."""
    _, target, move = step
    found, resets = [*record.constraints(move.action.guard), *record.invariant], move.action.resets
    for bound in target.discrete.invariant if move.error is None else ():
        if bound.clock not in resets:
            found += record.constraints((bound,))
        elif not bound.allows(resets[bound.clock]):
            return None
    return tuple(found)
