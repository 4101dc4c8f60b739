"""What a move does to zones, compiled: guard, settings of clocks, delay, invariant, widening.

Zones hold only the clocks that are active in their discrete state, so a move also drops and adds clocks: all of it
is one rearrangement of the matrix. Equal plans are shared, and remember what they made of each zone: states that
differ in data only, and repeat in time, cost a look-up.
"""

from __future__ import annotations

from collections.abc import Sequence
from operator import itemgetter

from timed_automata.explore.zones import INFINITY, Constraint, Unique, Widening, Zone, extrapolated, tighten


class Plan:
    """The way of zones along a move.

    Args:
        n: size of the zones that it takes.
        guard: constraints on them.
        sources: for each place of the zone that results, the place it is taken from, or the value that it is set
            to and 0: ``(place, value)``; x_0 first.
        delays: whether time passes then.
        invariant: constraints on what results.
        limits: how to widen it; None: not at all.
        unique: all zones so far: what results is the one object for its bounds. None: any object.

    Attributes:
        known: what became of the zones so far.
    """

    __slots__ = ("_add", "_gather", "_guard", "_invariant", "_limits", "_n", "_size", "_unique", "known")

    def __init__(
        self,
        n: int,
        guard: tuple[Constraint, ...],
        sources: Sequence[tuple[int, int]],
        delays: bool,
        invariant: tuple[Constraint, ...],
        limits: Widening | None,
        unique: dict[Zone, Zone] | None = None,
    ) -> None:
        size = len(sources)
        places = [
            n * n if delays and i and not j else sources[i][0] * n + sources[j][0]
            for i in range(size)
            for j in range(size)
        ]
        for i in range(size):
            places[i * size + i] = 0
        values = [value for _, value in sources]
        self._add = None
        if any(values):
            self._add = [2 * (values[i] - values[j]) for i in range(size) for j in range(size)]
        self._n, self._size, self._guard, self._invariant, self._limits = n, size, guard, invariant, limits
        self._gather = itemgetter(*places) if size > 1 else None
        self.known: dict[Zone, Zone | None] = {}
        self._unique = unique

    def __call__(self, zone: Zone) -> Zone | None:
        """What becomes of a zone; None if nothing is left."""
        try:
            return self.known[zone]
        except KeyError:
            result = self._follow(zone)
            if result is not None and self._unique is not None:
                result = self._unique.get(result) or self._unique.setdefault(result, Unique(result))
            self.known[zone] = result
            return result

    def _follow(self, zone: Zone) -> Zone | None:
        n = self._n
        changed: list[int] | None = None
        for i, j, bound in self._guard:
            if changed is None:
                if bound >= zone[i * n + j]:
                    continue
                changed = list(zone)
            if not tighten(changed, n, i, j, bound):
                return None
        if self._gather is None:
            return (1,)
        result: list[int] = list(self._gather((*(zone if changed is None else changed), INFINITY)))
        n = self._size
        if self._add is not None:
            result = [
                bound if bound == INFINITY else bound + more
                for bound, more in zip(result, self._add, strict=True)
            ]
        for i, j, bound in self._invariant:
            if bound < result[i * n + j] and not tighten(result, n, i, j, bound):
                return None
        return tuple(result) if self._limits is None else extrapolated(result, n, self._limits)
