"""Zones over the clocks of both networks of a comparison."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from timed_automata.compiler import Bound
from timed_automata.explore.zones import (
    AT_MOST_ZERO,
    INFINITY,
    Limit,
    Limits,
    Zone,
    as_constraints,
    constrained,
    constraints_of,
    extrapolated,
    subtract,
    up,
    widening,
)
from timed_automata.inclusion._interface import Side
from timed_automata.network import State


class CommonZones:
    """The zones of two sides: the clocks x_1, x_2, … are those tested in the first, then those tested in the second."""

    def __init__(self, both: Sequence[Side]) -> None:
        self._both = both
        self.n = 1 + sum(len(side.index) for side in both)
        self._places = {place: place for place in range(1, self.n)}
        # what a guard does not allow is asked for, too: the same limit for lower and upper bounds
        self._limits = [Limits(side.network, symmetric=True) for side in both]

    @property
    def start(self) -> Zone:
        """The zone in which all clocks are zero."""
        return (AT_MOST_ZERO,) * (self.n * self.n)

    def within(self, zone: Zone, bounds: Iterable[Bound]) -> Zone | None:
        """Return the part of a zone that satisfies all bounds, or None if it is empty."""
        return constrained(zone, self.n, as_constraints(bounds, self._places))

    def without(self, zones: Sequence[Zone], bounds: Iterable[Bound]) -> list[Zone]:
        """Return the parts of zones that do not satisfy all bounds."""
        constraints = as_constraints(bounds, self._places)
        return [piece for zone in zones for piece in subtract(zone, constraints, self.n)]

    def later(self, zone: Zone) -> Zone:
        """Return the zone after any delay."""
        return up(zone, self.n)

    def set(self, zone: Zone, resets: Mapping[int, int]) -> Zone:
        """Return the zone with clocks set to values."""
        n, found = self.n, list(zone)
        for place, value in resets.items():
            for other in range(n):
                lower, upper = found[other], found[other * n]
                found[place * n + other] = lower + 2 * value
                found[other * n + place] = upper - 2 * value if upper != INFINITY else INFINITY
            found[place * n + place] = AT_MOST_ZERO
        return tuple(found)

    def widened(self, zone: Zone, states: Sequence[State]) -> Zone:
        """Return a zone extended by equivalent valuations: beyond the largest constant a clock's value does not
        matter.
        """
        limits = [Limit()] * (self.n - 1)
        for side, known, state in zip(self._both, self._limits, states, strict=True):
            at = known.at(state.locations)
            for clock, place in side.index.items():
                limits[place - 1] = at.get(clock, Limit())
        return extrapolated(list(zone), self.n, widening(limits))

    def constraints(self, zone: Zone) -> list[tuple[int, int, int]]:
        """Return the bounds of a zone that are a restriction."""
        return constraints_of(zone, self.n)
