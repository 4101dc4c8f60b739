"""Finds where a condition holds in a symbolic state, and lets time pass there: freely, or only while it holds."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import NamedTuple

from timed_automata.explore.search._deadlock import Deadlocks
from timed_automata.explore.states import StateRecord
from timed_automata.explore.zones import Zone, constrained, constraints_of, subtract, up
from timed_automata.explore.zones._zone import Constraint, everything, intersection
from timed_automata.queries import Formula

ZoneCase = tuple[tuple[Constraint, ...], bool | None]


class ZoneCondition:
    """A condition; for every discrete state it is evaluated once into constraints on the clocks."""

    def __init__(self, formula: Formula) -> None:
        self._formula = formula
        self._deadlocks = Deadlocks()
        self._known: dict[StateRecord, tuple[ZoneCase, ...]] = {}

    def of(self, record: StateRecord) -> tuple[ZoneCase, ...]:
        """Return the cases of the condition: clock constraints, and whether a deadlock must or must not exist (None:
        either).
        """
        found = self._known.get(record)
        if found is None:
            cases = self._formula.cases(record.discrete.state)
            found = tuple((record.constraints(bounds), deadlock) for bounds, deadlock in cases)
            self._known[record] = found
        return found

    def forget(self) -> None:
        """Drop cached results."""
        self._known.clear()
        self._deadlocks.forget()

    def part(self, record: StateRecord, zone: Zone) -> Zone | None:
        """Return a part of a zone in which the condition holds, or None if there is none."""
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
    """A zone at entry, and the zone that time leads to from there; every point of ``entry`` reaches any later one of
    ``zone``.
    """

    entry: Zone
    zone: Zone


Grow = Callable[[StateRecord, Zone], list[DelayedZone]]


def freely(record: StateRecord, zone: Zone) -> list[DelayedZone]:
    """Let time pass as far as the invariant allows."""
    if not record.discrete.delays:
        return [DelayedZone(zone, zone)]
    later = constrained(up(zone, record.n), record.n, record.invariant)
    return [] if later is None else [DelayedZone(zone, later)]


class Only:
    """Allows no delay, and enters only where a condition holds."""

    def __init__(self, inside: ZoneCondition) -> None:
        self.inside = inside

    def __call__(self, record: StateRecord, zone: Zone) -> list[DelayedZone]:
        """Return the parts of a zone in which the condition holds."""
        cases = (constrained(zone, record.n, constraints) for constraints, _ in self.inside.of(record))
        return [DelayedZone(part, part) for part in cases if part is not None]


class Within:
    """Enters only where a condition holds, and lets time pass while it holds.

    The first valuation outside of the condition ends a delay. For one convex set B outside, a delay from A reaches A↑
    minus B↑ (before B), and all that follows the part of A past B; for several sets, the intersection (the mirror
    image of Predt in Behrmann, Cougnard, David, Fleury, Larsen, Lime, *UPPAAL-Tiga*, 2007).
    """

    def __init__(self, inside: ZoneCondition, outside: ZoneCondition) -> None:
        self.inside, self.outside = inside, outside

    def __call__(self, record: StateRecord, zone: Zone) -> list[DelayedZone]:
        """Return the possible stays from a zone inside the invariant."""
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
    """Return the possible stays that avoid one convex set."""
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
