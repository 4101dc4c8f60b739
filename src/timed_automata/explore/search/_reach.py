"""Searches over symbolic states: breadth first for the shortest symbolic run, or widest first for worst cases."""

from __future__ import annotations

import gc
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from heapq import heappop, heappush
from itertools import compress, count
from operator import attrgetter, le, not_

from timed_automata.errors import RangeError
from timed_automata.explore.search._concrete import Leg
from timed_automata.explore.search._stages import SearchNode, Stage, Stages
from timed_automata.explore.states import StateRecord, SymbolicSpace
from timed_automata.explore.states._discrete import Action
from timed_automata.explore.states._symbolic import Form
from timed_automata.explore.zones import Zone
from timed_automata.explore.zones._zone import guard_bits, packed

Progress = Callable[[int], None]
EVERY = 1000  # states between two words on progress
MANY = 24  # zones of a discrete state: from here on it pays to pack each into one integer
_packed = attrgetter("packed")
_UNKNOWN: Zone = ()  # what becomes of a zone is not known yet


@contextmanager
def without_collector() -> Iterator[None]:
    """Disable the garbage collector: nothing that a search keeps is garbage, and looking for some takes long."""
    collected = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collected:
            gc.enable()


class OutOfRangeError(RangeError):
    """An update, a guard or an index left its range in a reachable state; ``legs`` lead there."""

    def __init__(self, error: RangeError, legs: list[Leg]) -> None:
        super().__init__(error.what, where=error.where, todo=error.todo)
        self.legs = legs


class Search:
    """A search from the initial state; ``states`` counts the symbolic states stored.

    A state is not stored if its zone lies inside that of another state with the same discrete state, and it is not
    expanded if a larger zone is found later. Both are sound for reachability.

    Args:
        space: a space in which equal zones are one object.
        progress: called now and then with the number of states.
    """

    def __init__(self, space: SymbolicSpace, progress: Progress | None = None) -> None:
        self.space, self._progress = space, progress
        self.states = 0
        self._waiting: deque[SearchNode] = deque()

    def nodes(self) -> Iterator[SearchNode]:
        """Yield every symbolic state when it is found.

        Raises:
            OutOfRangeError: a value leaves its range on the way.
        """
        node: SearchNode | None = self._found(*self.space.initial(), None, None)
        assert node is not None
        yield node
        while (node := self._next()) is not None:
            if node.covered:
                continue
            zone = node.zone
            try:
                steps = node.record.steps
            except RangeError as error:
                raise OutOfRangeError(error, node.legs) from None
            for plan, target, move in steps:
                after = plan.known.get(zone, _UNKNOWN)
                if after is _UNKNOWN:
                    after = plan(zone)
                if after is None:
                    continue
                if move.error is not None:
                    raise OutOfRangeError(move.error, [*node.legs, Leg(move)])
                if not target.passed or not _covered(after, target.passed):
                    yield self._found(target, after, node, move.action)

    # The order of the search

    def _put(self, node: SearchNode) -> None:
        self._waiting.append(node)

    def _next(self) -> SearchNode | None:
        return self._waiting.popleft() if self._waiting else None

    # What is stored

    def _found(
        self, record: StateRecord, zone: Zone, parent: SearchNode | None, action: Action | None
    ) -> SearchNode:
        node = SearchNode(record, zone, parent, action)
        if record.passed:
            self._overtake(node)
        else:
            record.passed = [node]
        self.states += 1
        if self._progress is not None and not self.states % EVERY:
            self._progress(self.states)
        self._put(node)
        return node

    def _overtake(self, node: SearchNode) -> None:
        passed = node.record.passed
        inside = list(_inside(node))
        if True in inside:
            for other in compress(passed, inside):
                other.covered = True
            passed = list(compress(passed, map(not_, inside)))
        node.record.passed = [*passed, node]


def _covered(zone: Zone, others: Sequence[SearchNode]) -> bool:
    """Return whether a zone lies inside the zone of one of the nodes."""
    for other in others:
        if other.zone is zone:
            return True
    if len(others) < MANY:
        return any(all(map(le, zone, other.zone)) for other in others)
    guards = guard_bits(len(zone))
    differences = map((guards - packed(zone)).__add__, map(_packed, others))
    return guards in map(guards.__and__, differences)  # the loop is in C: this is most of a large search


def _inside(node: SearchNode) -> Iterator[bool]:
    """Yield, for every node with the same discrete state, whether its zone lies inside that of this one."""
    zone, others = node.zone, node.record.passed
    if len(others) < MANY:
        return (all(map(le, other.zone, zone)) for other in others)
    guards = guard_bits(len(zone))
    differences = map((guards + node.packed).__sub__, map(_packed, others))
    return map(guards.__eq__, map(guards.__and__, differences))


class WidestFirst(Search):
    """Finds the same states as :class:`Search`, but not by the shortest runs, and does not keep the runs.

    It works in stages, the lowest rank first (:class:`Stage`); a finished stage is passed to ``done`` and dropped.
    Within a stage, states in which none of the ``clocks`` is used come first, because they lead to states that use
    them. States without delay come before those in which time passes: so a state that is reached by several such steps
    is expanded once. A discrete state that is reached again waits until all new ones are expanded. By then the steps
    between discrete states are known, and a state is expanded after its predecessors, because one of them might reach
    it again with a larger zone (topological order: Herbreteau, Tran, *Improving Search Order for Reachability Testing
    in Timed Automata*, 2015).

    Args:
        space: as for :class:`Search`.
        clocks: states in which one of these clocks can be largest are expanded first.
        progress: called now and then with the number of states.
        done: called with every stage when no state can lead to it any more.
    """

    def __init__(
        self,
        space: SymbolicSpace,
        clocks: Sequence[int],
        progress: Progress | None = None,
        done: Callable[[Stage], None] = lambda _: None,
    ) -> None:
        super().__init__(space, progress)
        self._clocks, self._done = tuple(clocks), done
        self._stages = Stages(space.discrete.network)
        self._ahead: list[tuple[int, int, Stage]] = []  # a heap of the stages that wait
        self._stage: Stage | None = None  # which is being followed
        self._again, self._count = False, count()
        self._uppers: dict[Form, list[int]] = {}

    def _put(self, node: SearchNode) -> None:
        stage, form = node.record.stage, node.record.form
        uppers = self._uppers.get(form)
        if uppers is None:
            uppers = [form.index[clock] * form.n for clock in self._clocks if clock in form.index]
            self._uppers[form] = uppers
        if self._again and uppers:
            if stage.order:
                self._put_in_order(stage, node)
            else:
                stage.again.append(node)
        elif uppers:
            heappush(stage.heap, (-self._widest(node), form.delays, next(self._count), node))
        elif form.delays:
            stage.waiting.append(node)
        else:
            stage.still.append(node)

    def _widest(self, node: SearchNode) -> int:
        zone = node.zone
        return max([zone[at] for at in self._uppers[node.record.form]], default=0)

    def _put_in_order(self, stage: Stage, node: SearchNode) -> None:
        order = stage.order.get(node.record, 0)
        heappush(stage.ordered, (order, -self._widest(node), next(self._count), node))

    def _next(self) -> SearchNode | None:
        while True:
            stage = self._stage
            if stage is not None:
                if stage.still:
                    return stage.still.popleft()
                if stage.waiting:
                    return stage.waiting.popleft()
                if stage.heap:
                    return heappop(stage.heap)[-1]
                if stage.again:
                    stage.put_in_order()
                    for node in stage.again:
                        self._put_in_order(stage, node)
                    stage.again = []
                if stage.ordered:
                    return heappop(stage.ordered)[-1]
                self._done(stage)
                stage.forget()
            self._stage = heappop(self._ahead)[-1] if self._ahead else None
            if self._stage is None:
                return None

    def _found(
        self, record: StateRecord, zone: Zone, parent: SearchNode | None, action: Action | None
    ) -> SearchNode:
        self._again = bool(record.passed)
        if not self._again:
            stage = record.stage = self._stages.of(record, self._stage)
            assert not stage.done, "a stage that was done is entered"
            if not stage.records and stage is not self._stage:
                heappush(self._ahead, (stage.level.rank, len(self._stages), stage))
            stage.records.append(record)
        return super()._found(record, zone, None, None)
