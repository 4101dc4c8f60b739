"""Deadlock: no transition is enabled, now or after any time that the invariant allows."""

from __future__ import annotations

from timed_automata.explore._bound import INFINITY
from timed_automata.explore._symbolic import Place, Step
from timed_automata.explore._zone import (
    Constraint,
    Zone,
    constrained,
    constraints_of,
    down,
    everything,
    subtract,
)

Way = tuple[Constraint, ...]


def enabling(place: Place, step: Step) -> tuple[Constraint, ...] | None:
    """What the clocks must satisfy at the instant of a move: guard, invariant here, invariant there."""
    _, target, move = step
    found = [*place.constraints(move.guard), *place.invariant]
    for clock, op, value in target.discrete.invariant if move.error is None else ():
        if clock not in move.resets:
            found += place.constraints(((clock, op, value),))  # type: ignore[arg-type]
        elif not (move.resets[clock] < value or (op == "<=" and move.resets[clock] == value)):
            return None
    return tuple(found)


def enabling_key(place: Place, step: Step) -> object:
    """All that the above depends on, and whether time passes."""
    _, target, move = step
    return move.label, place.form, target.form if move.error is None else None


class Deadlocks:
    """Finds the valuations without a way on; what lets a state go on is computed once per discrete state."""

    def __init__(self) -> None:
        self._ways: dict[Place, tuple[Way, ...]] = {}
        self._known: dict[object, Way | None] = {}

    def ways(self, place: Place) -> tuple[Way, ...]:
        """Zones, as constraints, from which a transition is taken now or later."""
        found = self._ways.get(place)
        if found is None:
            ways = {way for step in place.steps if (way := self._way(place, step)) is not None}
            found = self._ways[place] = ((),) if () in ways else tuple(ways)
        return found

    def _way(self, place: Place, step: Step) -> Way | None:
        key = enabling_key(place, step)
        if key not in self._known:
            needed, n = enabling(place, step), place.n
            zone = None if needed is None else constrained(everything(n), n, needed)
            if zone is not None and place.discrete.delays:
                zone = down(zone, n)
            self._known[key] = None if zone is None else tuple(constraints_of(zone, n))
        return self._known[key]

    def of(self, place: Place, zone: Zone) -> list[Zone]:
        """The parts of a zone that are deadlocked, inside the invariant: widened zones may reach beyond it."""
        inside, n = constrained(zone, place.n, place.invariant), place.n
        left = [] if inside is None else [inside]
        for way in self.ways(place):
            left = [piece for part in left for piece in subtract(part, way, n)]
            if not left:
                break
        return left


def ends_time(place: Place, zone: Zone) -> bool:
    """Whether time cannot pass without end from some valuation of the zone."""
    return not place.discrete.delays or any(bound != INFINITY for bound in zone[place.n :: place.n])
