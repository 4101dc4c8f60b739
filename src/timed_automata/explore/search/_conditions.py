"""Where a condition holds in a symbolic state, and how time passes there: freely, or only as long as it holds."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import NamedTuple

from timed_automata.explore.search._deadlock import Deadlocks
from timed_automata.explore.states import StateRecord
from timed_automata.explore.zones import (
    Constraint,
    Zone,
    constrained,
    constraints_of,
    everything,
    intersection,
    subtract,
    up,
)
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

    def forget(self) -> None:
        """Drop what is known of records."""
        self._known.clear()
        self._deadlocks.forget()

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


class DelayedZone(NamedTuple):
    """Where a run enters and where time takes it from there; any point of ``entry`` leads to any later of ``zone``."""

    entry: Zone
    zone: Zone


Grow = Callable[[StateRecord, Zone], list[DelayedZone]]


def freely(record: StateRecord, zone: Zone) -> list[DelayedZone]:
    """As far as the invariant allows."""
    if not record.discrete.delays:
        return [DelayedZone(zone, zone)]
    later = constrained(up(zone, record.n), record.n, record.invariant)
    return [] if later is None else [DelayedZone(zone, later)]


class Only:
    """No delay, and only where a condition holds."""

    def __init__(self, inside: ZoneCondition) -> None:
        self.inside = inside

    def __call__(self, record: StateRecord, zone: Zone) -> list[DelayedZone]:
        """The parts of a zone in which the condition holds."""
        cases = (constrained(zone, record.n, constraints) for constraints, _ in self.inside.of(record))
        return [DelayedZone(part, part) for part in cases if part is not None]


class Within:
    """As long as a condition holds, entered only where it does.

    A delay is stopped by the first valuation outside. For a convex set B outside, what is reached from A is
    A↑ minus B↑ (B not met), and what comes after those of A that are past B; for several the common part
    (the mirror image of Predt in Behrmann, Cougnard, David, Fleury, Larsen, Lime, *UPPAAL-Tiga*, 2007).
    """

    def __init__(self, inside: ZoneCondition, outside: ZoneCondition) -> None:
        self.inside, self.outside = inside, outside

    def __call__(self, record: StateRecord, zone: Zone) -> list[DelayedZone]:
        """The ways to stay, from a zone inside the invariant."""
        n, found = record.n, []
        for constraints, _ in self.inside.of(record):
            entry = constrained(zone, n, constraints)
            if entry is None:
                continue
            if not record.discrete.delays:
                found.append(DelayedZone(entry, entry))
                continue
            for stay in self._avoiding(record, entry):
                later = constrained(stay.zone, n, record.invariant)
                if later is not None:
                    found.append(DelayedZone(stay.entry, later))
        return found

    def _avoiding(self, record: StateRecord, zone: Zone) -> list[DelayedZone]:
        n = record.n
        ways = [
            _past(zone, outside, n)
            for constraints, _ in self.outside.of(record)
            if (outside := constrained(everything(n), n, constraints)) is not None
        ]
        if not ways:
            return [DelayedZone(zone, up(zone, n))]
        found = []
        for choice in product(*ways):
            stay: DelayedZone | None = choice[0]
            for other in choice[1:]:
                stay = _common(stay, other, n) if stay else None
            if stay:
                found.append(stay)
        return found


def _past(zone: Zone, outside: Zone, n: int) -> list[DelayedZone]:
    """The ways to stay clear of one convex set."""
    after = constraints_of(up(outside, n), n)
    found = [DelayedZone(zone, piece) for piece in subtract(up(zone, n), after, n)]
    behind = constrained(zone, n, after)
    if behind is not None:
        found += [
            DelayedZone(piece, up(piece, n)) for piece in subtract(behind, constraints_of(outside, n), n)
        ]
    return found


def _common(left: DelayedZone, right: DelayedZone, n: int) -> DelayedZone | None:
    entry, zone = intersection(left.entry, right.entry, n), intersection(left.zone, right.zone, n)
    return None if entry is None or zone is None else DelayedZone(entry, zone)
