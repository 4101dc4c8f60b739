"""Letting time pass in a place: freely, or only as long as a condition holds."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import NamedTuple

from timed_automata.explore._cases import Cases
from timed_automata.explore._symbolic import Place
from timed_automata.explore._zone import (
    Zone,
    constrained,
    constraints_of,
    everything,
    intersection,
    subtract,
    up,
)


class Stay(NamedTuple):
    """Where a run enters and where time takes it from there; any point of ``entry`` leads to any later of ``zone``."""

    entry: Zone
    zone: Zone


Grow = Callable[[Place, Zone], list[Stay]]


def freely(place: Place, zone: Zone) -> list[Stay]:
    """As far as the invariant allows."""
    if not place.discrete.delays:
        return [Stay(zone, zone)]
    later = constrained(up(zone, place.n), place.n, place.invariant)
    return [] if later is None else [Stay(zone, later)]


class Only:
    """No delay, and only where a condition holds."""

    def __init__(self, inside: Cases) -> None:
        self.inside = inside

    def __call__(self, place: Place, zone: Zone) -> list[Stay]:
        """The parts of a zone in which the condition holds."""
        cases = (constrained(zone, place.n, constraints) for constraints, _ in self.inside.of(place))
        return [Stay(part, part) for part in cases if part is not None]


class Within:
    """As long as a condition holds, entered only where it does.

    A delay is stopped by the first valuation outside. For a convex set B outside, what is reached from A is
    A↑ minus B↑ (B not met), and what comes after those of A that are past B; for several the common part
    (the mirror image of Predt in Behrmann, Cougnard, David, Fleury, Larsen, Lime, *UPPAAL-Tiga*, 2007).
    """

    def __init__(self, inside: Cases, outside: Cases) -> None:
        self.inside, self.outside = inside, outside

    def __call__(self, place: Place, zone: Zone) -> list[Stay]:
        """The ways to stay, from a zone inside the invariant."""
        n, found = place.n, []
        for constraints, _ in self.inside.of(place):
            entry = constrained(zone, n, constraints)
            if entry is None:
                continue
            if not place.discrete.delays:
                found.append(Stay(entry, entry))
                continue
            for stay in self._avoiding(place, entry):
                later = constrained(stay.zone, n, place.invariant)
                if later is not None:
                    found.append(Stay(stay.entry, later))
        return found

    def _avoiding(self, place: Place, zone: Zone) -> list[Stay]:
        n = place.n
        ways = [
            _past(zone, outside, n)
            for constraints, _ in self.outside.of(place)
            if (outside := constrained(everything(n), n, constraints)) is not None
        ]
        if not ways:
            return [Stay(zone, up(zone, n))]
        found = []
        for choice in product(*ways):
            stay: Stay | None = choice[0]
            for other in choice[1:]:
                stay = _common(stay, other, n) if stay else None
            if stay:
                found.append(stay)
        return found


def _past(zone: Zone, outside: Zone, n: int) -> list[Stay]:
    """The ways to stay clear of one convex set."""
    after = constraints_of(up(outside, n), n)
    found = [Stay(zone, piece) for piece in subtract(up(zone, n), after, n)]
    behind = constrained(zone, n, after)
    if behind is not None:
        found += [Stay(piece, up(piece, n)) for piece in subtract(behind, constraints_of(outside, n), n)]
    return found


def _common(left: Stay, right: Stay, n: int) -> Stay | None:
    entry, zone = intersection(left.entry, right.entry, n), intersection(left.zone, right.zone, n)
    return None if entry is None or zone is None else Stay(entry, zone)
