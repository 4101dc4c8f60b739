"""The part of a symbolic state in which a condition holds."""

from __future__ import annotations

from timed_automata.explore._deadlock import Deadlocks
from timed_automata.explore._formula import Formula
from timed_automata.explore._symbolic import Place
from timed_automata.explore._zone import Constraint, Zone, constrained

Split = tuple[tuple[Constraint, ...], bool | None]


class Cases:
    """A condition, evaluated once per discrete state into what the clocks must satisfy."""

    def __init__(self, formula: Formula) -> None:
        self._formula = formula
        self._deadlocks = Deadlocks()
        self._known: dict[Place, tuple[Split, ...]] = {}

    def of(self, place: Place) -> tuple[Split, ...]:
        """Constraints and deadlock of each case."""
        found = self._known.get(place)
        if found is None:
            cases = self._formula.cases(place.discrete.state)
            found = tuple((place.constraints(bounds), deadlock) for bounds, deadlock in cases)
            self._known[place] = found
        return found

    def part(self, place: Place, zone: Zone) -> Zone | None:
        """A part of a zone in which the condition holds; None if there is none."""
        for constraints, deadlock in self.of(place):
            part = constrained(zone, place.n, constraints) if constraints else zone
            if part is not None and deadlock is not None:
                part = self._stuck(place, part) if deadlock else self._live(place, part)
            if part is not None:
                return part
        return None

    def _stuck(self, place: Place, zone: Zone) -> Zone | None:
        return next(iter(self._deadlocks.of(place, zone)), None)

    def _live(self, place: Place, zone: Zone) -> Zone | None:
        for way in self._deadlocks.ways(place):
            part = constrained(zone, place.n, way)
            if part is not None:
                return part
        return None
