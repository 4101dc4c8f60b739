"""The effect of a move on zones, compiled: guard, settings of clocks, delay, invariant, widening.

A zone contains only the clocks that are active in its discrete state, so a move also removes and adds clocks: all of
it is one rearrangement of the matrix. Equal plans are shared and cache their result for every zone, so that states
that differ only in data, and repeat in time, cost one look-up.
"""

from __future__ import annotations

from collections.abc import Sequence
from operator import itemgetter

from timed_automata.explore.zones import AT_MOST_ZERO, INFINITY, Zone, extrapolated
from timed_automata.explore.zones._extrapolation import Widening
from timed_automata.explore.zones._zone import Constraint, UniqueZones, delay, tighten


class Rearrangement:
    """Maps the clocks of one zone to the clocks of the next.

    Args:
        n: size of the zones that it accepts.
        sources: for every place of the resulting zone a pair ``(place, value)``: the place it is copied from and 0, or
            place 0 and the value that it is set to; x_0 comes first.
    """

    __slots__ = ("_add", "_gather", "n", "size")

    def __init__(self, n: int, sources: Sequence[tuple[int, int]]) -> None:
        self.n, self.size = n, len(sources)
        places = [i * n + j for i, _ in sources for j, _ in sources]
        places[:: self.size + 1] = [0] * self.size
        values = [value for _, value in sources]
        self._add = [2 * (left - right) for left in values for right in values] if any(values) else None
        self._gather = itemgetter(*places) if self.size > 1 else None

    def __call__(self, zone: Sequence[int]) -> list[int]:
        """Return the rearranged bounds."""
        if self._gather is None:
            return [AT_MOST_ZERO]
        found = self._gather(zone)
        if self._add is None:
            return list(found)
        return [
            bound if bound == INFINITY else bound + more for bound, more in zip(found, self._add, strict=True)
        ]


class Plan:
    """Computes the zone that a move leads to.

    Args:
        guard: constraints on the zones that it accepts.
        rearrangement: mapping of their clocks.
        delays: whether time passes after the move.
        invariant: constraints on the result.
        limits: limits for widening the result; None: no widening.
        unique: makes equal results one object; None: results are not made unique.

    Attributes:
        known: results for the zones so far.
    """

    __slots__ = ("_delays", "_guard", "_invariant", "_limits", "_rearranged", "_unique", "known")

    def __init__(
        self,
        guard: tuple[Constraint, ...],
        rearrangement: Rearrangement,
        delays: bool,
        invariant: tuple[Constraint, ...],
        limits: Widening | None,
        unique: UniqueZones | None = None,
    ) -> None:
        self._guard, self._rearranged, self._delays = guard, rearrangement, delays
        self._invariant, self._limits, self._unique = invariant, limits, unique
        self.known: dict[Zone, Zone | None] = {}

    def __call__(self, zone: Zone) -> Zone | None:
        """Return the zone after the move, or None if it is empty."""
        try:
            return self.known[zone]
        except KeyError:
            result = self._follow(zone)
            if result is not None and self._unique is not None:
                result = self._unique.of(result)
            self.known[zone] = result
            return result

    def _follow(self, zone: Zone) -> Zone | None:
        n = self._rearranged.n
        changed: list[int] | None = None
        for i, j, bound in self._guard:
            if changed is None:
                if bound >= zone[i * n + j]:
                    continue
                changed = list(zone)
            if not tighten(changed, n, i, j, bound):
                return None
        result = self._rearranged(zone if changed is None else changed)
        n = self._rearranged.size
        if self._delays:
            upper = [(i, bound) for i, j, bound in self._invariant if not j]
            for i, bound in upper:
                if bound < result[i * n] and not tighten(result, n, i, 0, bound):
                    return None
            delay(result, n, upper)
        for i, j, bound in self._invariant:
            if bound < result[i * n + j] and not tighten(result, n, i, j, bound):
                return None
        return tuple(result) if self._limits is None else extrapolated(result, n, self._limits)
