"""A search that follows first what has taken longest: where a worst case is looked for, less is overtaken."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from heapq import heappop, heappush

from timed_automata.explore.search._reach import Progress, Search, SearchNode
from timed_automata.explore.states import Form, Move, StateRecord, SymbolicSpace
from timed_automata.explore.zones import Zone


class WidestFirst(Search):
    """Finds the same states as :class:`Search`, not by the shortest runs, and does not keep the runs.

    Where none of the clocks runs yet comes before all else: it leads to where they do. Where time vectors still comes
    before where it passes: what is reached there by many ways is then followed once. A discrete state that is met again
    waits until all new ones are followed: what overtakes it may be overtaken itself.

    Args:
        space: as for :class:`Search`.
        clocks: states in which one of these can be largest are expanded first.
        progress: called with the number of states now and then.
    """

    def __init__(self, space: SymbolicSpace, clocks: Sequence[int], progress: Progress | None = None) -> None:
        super().__init__(space, progress)
        self._clocks = tuple(clocks)
        self._heap: list[tuple[bool, int, bool, int, SearchNode]] = []
        self._still: deque[SearchNode] = deque()
        self._again = False
        self._uppers: dict[Form, list[int]] = {}

    def _put(self, node: SearchNode) -> None:
        form = node.record.form
        uppers = self._uppers.get(form)
        if uppers is None:
            uppers = [form.index[clock] * form.n for clock in self._clocks if clock in form.index]
            self._uppers[form] = uppers
        if uppers:
            zone = node.zone
            widest = max([zone[at] for at in uppers])
            heappush(self._heap, (self._again, -widest, form.delays, self.states, node))
        elif form.delays:
            self._waiting.append(node)
        else:
            self._still.append(node)

    def _next(self) -> SearchNode | None:
        if self._still:
            return self._still.popleft()
        if self._waiting:
            return self._waiting.popleft()
        return heappop(self._heap)[-1] if self._heap else None

    def _found(
        self, record: StateRecord, zone: Zone, parent: SearchNode | None, move: Move | None
    ) -> SearchNode:
        self._again = bool(record.passed)
        return super()._found(record, zone, None, None)
