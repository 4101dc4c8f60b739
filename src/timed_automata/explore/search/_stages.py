"""Divides a search into stages: the progress measure of the sweep-line method.

States that a run can never reach again need no memory (Christensen, Kristensen, Mailund, *A Sweep-Line Method for
State Space Exploration*, 2001). The measure is computed from the network. A process that leaves a strongly connected
component of its locations never returns to it: the depth of a component never falls along an edge, and rises where a
component is left. The rank of a location vector is the sum of the depths over the processes. A variable is settled if
no edge that a process can still take writes it.

A stage is a component for every process, and the values that are settled there. A step stays in its stage or leads to
a higher rank: settled values do not change, and a variable becomes settled only where a component is left. So stages
of equal rank do not reach each other, and a stage is never entered again when it and all stages of lower rank are
done. The search asserts that.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from graphlib import TopologicalSorter
from operator import itemgetter
from typing import NamedTuple

from timed_automata.compiler import Values
from timed_automata.explore.search._concrete import Leg
from timed_automata.explore.search._cycles import components, strong
from timed_automata.explore.states import Move, StateRecord
from timed_automata.explore.states._discrete import Action
from timed_automata.explore.zones import Zone
from timed_automata.explore.zones._zone import packed
from timed_automata.network import Network, Process


class SearchNode:
    """A reached symbolic state, with its predecessor and the action that led to it."""

    __slots__ = ("_packed", "action", "covered", "parent", "record", "zone")

    def __init__(
        self, record: StateRecord, zone: Zone, parent: SearchNode | None, action: Action | None
    ) -> None:
        self.record, self.zone, self.parent, self.action = record, zone, parent, action
        self.covered, self._packed = False, 0

    @property
    def packed(self) -> int:
        """The zone packed into one integer, computed at first use."""
        if not self._packed:
            self._packed = packed(self.zone)
        return self._packed

    @property
    def move(self) -> Move | None:
        """The last move of the run to this state."""
        return None if self.action is None else Move(self.action, self.record.discrete)

    @property
    def legs(self) -> list[Leg]:
        """The legs of the run from the initial state to this state."""
        legs = []
        node: SearchNode | None = self
        while node is not None:
            legs.append(Leg(node.move))
            node = node.parent
        return legs[::-1]


class Level:
    """One component per process; there is one object for every combination that was reached.

    Attributes:
        rank: the sum of the depths of the components.
        settled: returns the values that do not change any more.
    """

    __slots__ = ("rank", "settled")

    def __init__(self, rank: int, settled: Callable[[Values], object]) -> None:
        self.rank, self.settled = rank, settled


class Stage:
    """A set of states whose predecessors are all in this stage or in stages of lower rank.

    Attributes:
        level: the level of all its states.
        records: the records with a zone, in the order in which they were found.
        still, waiting, heap: queues of nodes that are the first of their discrete state.
        again, ordered: queues of the other nodes; ``ordered`` follows the steps between discrete states once these are
        known.
        order: number of a record in that order.
        done: whether all nodes are expanded.
    """

    __slots__ = ("again", "done", "heap", "level", "order", "ordered", "records", "still", "waiting")

    def __init__(self, level: Level) -> None:
        self.level, self.done = level, False
        self.records: list[StateRecord] = []
        self.still: deque[SearchNode] = deque()
        self.waiting: deque[SearchNode] = deque()
        self.heap: list[tuple[int, bool, int, SearchNode]] = []
        self.again: list[SearchNode] = []
        self.ordered: list[tuple[int, int, int, SearchNode]] = []
        self.order: dict[StateRecord, int] = {}

    def put_in_order(self) -> None:
        """Number the records so that each one comes after its predecessors, except on cycles."""
        graph = {
            record: [target for _, target, _ in record.steps if target.stage is self]
            for record in self.records
        }
        for number, component in enumerate(strong(graph)):
            for record in component:
                self.order[record] = -number

    def forget(self) -> None:
        """Drop all data of the stage, because no state leads to it any more."""
        self.done, self.records, self.order = True, [], {}


class Stages:
    """The stages of a network that a search has reached."""

    def __init__(self, network: Network) -> None:
        self._network = network
        self._regions = [_regions(process) for process in network.processes]
        self._levels: dict[tuple[int, ...], Level] = {}
        self._level_of: dict[object, Level] = {}  # a location vector
        self._stages: dict[tuple[Level, object], Stage] = {}

    def __len__(self) -> int:
        return len(self._stages)

    def of(self, record: StateRecord, before: Stage | None) -> Stage:
        """Return the stage of a record that a step from the stage ``before`` leads to; ``before`` is None for the
        first one.
        """
        vector = record.discrete.vector
        level = self._level_of.get(vector)
        if level is None:
            level = self._level_of[vector] = self._level(vector.locations)
        if before is not None and before.level is level:
            return before
        key = level, level.settled(record.discrete.state.values)
        stage = self._stages.get(key)
        if stage is None:
            stage = self._stages[key] = Stage(level)
        return stage

    def _level(self, locations: tuple[int, ...]) -> Level:
        here = [regions[at] for regions, at in zip(self._regions, locations, strict=True)]
        numbers = tuple(region.number for region in here)
        level = self._levels.get(numbers)
        if level is None:
            written = frozenset[str]().union(*(region.written for region in here))
            offsets = [
                variable.offset + at
                for variable in self._network.variables
                if variable.name not in written
                for at in range(variable.type.size)
            ]
            settled = itemgetter(*offsets) if offsets else _nothing
            level = self._levels[numbers] = Level(sum(region.depth for region in here), settled)
        return level


def _nothing(_: Values) -> None:
    """Return the settled values if no value is settled: None."""


class _Region(NamedTuple):
    """A strongly connected component of the locations of a process, and the variables that are written in
    it or later.
    """

    number: int
    depth: int
    written: frozenset[str]


def _regions(process: Process) -> list[_Region]:
    """Return, for every location of a process, its strongly connected component."""
    edges = [edge for edge in process.edges if not edge.guard.never]
    graph: dict[int, list[int]] = {at: [] for at in range(len(process.locations))}
    for edge in edges:
        graph[edge.source].append(edge.target)
    number = list(graph)
    for component in components(graph):
        for at in component:
            number[at] = component[0]
    after: dict[int, set[int]] = {each: set() for each in number}
    written: dict[int, set[str]] = {each: set() for each in number}
    for edge in edges:
        source, target = number[edge.source], number[edge.target]
        written[source] |= edge.effects.writes
        if source != target:
            after[source].add(target)
    last_first = list(TopologicalSorter(after).static_order())
    depth = dict.fromkeys(last_first, 0)
    for each in last_first:
        written[each].update(*(written[other] for other in after[each]))
    for each in reversed(last_first):
        for other in after[each]:
            depth[other] = max(depth[other], depth[each] + 1)
    found = {each: _Region(each, depth[each], frozenset(written[each])) for each in after}
    return [found[each] for each in number]
