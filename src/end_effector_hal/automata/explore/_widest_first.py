"""A search that follows first what has taken longest: where a worst case is looked for, less is overtaken."""

from __future__ import annotations

from collections.abc import Sequence
from heapq import heappop, heappush

from end_effector_hal.automata.explore._discrete import Move
from end_effector_hal.automata.explore._reach import Node, Search, Told
from end_effector_hal.automata.explore._symbolic import Place, Shape, SymbolicSpace
from end_effector_hal.automata.explore._zone import Zone


class WidestFirst(Search):
    """Finds the same states as :class:`Search`, not by the shortest runs, and does not keep the runs.

    Args:
        space: as for :class:`Search`.
        clocks: states in which one of these can be largest are expanded first.
        told: called with the number of states now and then.
    """

    def __init__(self, space: SymbolicSpace, clocks: Sequence[int], told: Told | None = None) -> None:
        super().__init__(space, told)
        self._clocks = tuple(clocks)
        self._heap: list[tuple[int, int, Node]] = []
        self._uppers: dict[Shape, list[int]] = {}

    def _put(self, node: Node) -> None:
        heappush(self._heap, (self._rank(node.place.shape, node.zone), self.states, node))

    def _next(self) -> Node | None:
        return heappop(self._heap)[2] if self._heap else None

    def _found(self, place: Place, zone: Zone, parent: Node | None, move: Move | None) -> Node:
        return super()._found(place, zone, None, None)

    def _rank(self, shape: Shape, zone: Zone) -> int:
        """Lower first. Where none of the clocks runs yet comes before all else: it leads to where they do."""
        uppers = self._uppers.get(shape)
        if uppers is None:
            index, n = shape.index, shape.n
            uppers = self._uppers[shape] = [index[clock] * n for clock in self._clocks if clock in index]
        return -max([zone[at] for at in uppers]) if uppers else -1 << 60
