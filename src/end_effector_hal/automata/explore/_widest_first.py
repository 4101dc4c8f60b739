"""A search that follows first what has taken longest: where a worst case is looked for, less is overtaken."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from heapq import heappop, heappush
from operator import le

from end_effector_hal.automata._faults import RangeError
from end_effector_hal.automata.explore._reach import Node, OutOfRangeError, Search
from end_effector_hal.automata.explore._symbolic import Place, SymbolicSpace
from end_effector_hal.automata.explore._zone import Zone


class WidestFirst(Search):
    """Finds the same states as :class:`Search`, not by the shortest runs.

    Args:
        space: as for :class:`Search`.
        clocks: states in which one of these can be largest are expanded first.
    """

    def __init__(self, space: SymbolicSpace, clocks: Sequence[int]) -> None:
        super().__init__(space)
        self._clocks = tuple(clocks)

    def nodes(self) -> Iterator[Node]:
        """Each symbolic state as it is found.

        Raises:
            OutOfRangeError: a value leaves its range; without the way there.
        """
        place, zone = self.space.initial()
        first = Node(place, zone, None, None)
        self._store(first)
        waiting = [(0, 0, first)]
        yield first
        while waiting:
            node = heappop(waiting)[2]
            if node.covered:
                continue
            zone = node.zone
            try:
                steps = node.place.steps
            except RangeError as error:
                raise OutOfRangeError(error, []) from None
            for plan, target, move in steps:
                after = plan(zone)
                if after is None:
                    continue
                if move.error is not None:
                    raise OutOfRangeError(move.error, [])
                if after in target.seen:
                    continue
                for other in target.passed:
                    if all(map(le, after, other.zone)):
                        break
                else:
                    found = Node(target, after, node, move)
                    self._store(found)
                    heappush(waiting, (self._rank(target, after), self.states, found))
                    yield found

    def _rank(self, place: Place, zone: Zone) -> int:
        """Lower first. Where none of the clocks runs yet comes before all else: it leads to where they do."""
        bounds = [zone[at * place.n] for clock in self._clocks if (at := place.index.get(clock))]
        return -max(bounds, default=1 << 60)
