"""The part of a symbolic state in which a condition holds."""

from __future__ import annotations

from timed_automata.explore.search._deadlock import Deadlocks
from timed_automata.explore.states import StateRecord
from timed_automata.explore.zones import Constraint, Zone, constrained
from timed_automata.queries import Formula

ZoneCase = tuple[tuple[Constraint, ...], bool | None]


class ZoneCondition:
    """A condition, evaluated once per discrete state into what the clocks must satisfy."""

    def __init__(self, formula: Formula) -> None:
        self._formula = formula
        self._deadlocks = Deadlocks()
        self._known: dict[StateRecord, tuple[ZoneCase, ...]] = {}

    def of(self, record: StateRecord) -> tuple[ZoneCase, ...]:
        """Constraints and deadlock of each case."""
        found = self._known.get(record)
        if found is None:
            cases = self._formula.cases(record.discrete.state)
            found = tuple((record.constraints(bounds), deadlock) for bounds, deadlock in cases)
            self._known[record] = found
        return found

    def part(self, record: StateRecord, zone: Zone) -> Zone | None:
        """A part of a zone in which the condition holds; None if there is none."""
        for constraints, deadlock in self.of(record):
            part = constrained(zone, record.n, constraints) if constraints else zone
            if part is not None and deadlock is not None:
                part = self._deadlocks.part(record, part) if deadlock else self._live(record, part)
            if part is not None:
                return part
        return None

    def _live(self, record: StateRecord, zone: Zone) -> Zone | None:
        for way in self._deadlocks.ways(record):
            part = constrained(zone, record.n, way)
            if part is not None:
                return part
        return None
