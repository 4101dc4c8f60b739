"""Breadth-first search over symbolic states: the shortest symbolic run to whatever is looked for."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from operator import le

from end_effector_hal.automata._faults import RangeError
from end_effector_hal.automata.explore._concrete import Leg
from end_effector_hal.automata.explore._discrete import Move
from end_effector_hal.automata.explore._symbolic import Place, SymbolicSpace
from end_effector_hal.automata.explore._zone import Zone


class Node:
    """A symbolic state that was reached, and how."""

    __slots__ = ("covered", "move", "parent", "place", "zone")

    def __init__(self, place: Place, zone: Zone, parent: Node | None, move: Move | None) -> None:
        self.place, self.zone, self.parent, self.move = place, zone, parent, move
        self.covered = False

    @property
    def legs(self) -> list[Leg]:
        """The run from the initial state to here."""
        legs = []
        node: Node | None = self
        while node is not None:
            legs.append(Leg(node.move))
            node = node.parent
        return legs[::-1]


class OutOfRangeError(RangeError):
    """An update, a guard or an index left its range in a state that can be reached; ``legs`` are the way there."""

    def __init__(self, error: RangeError, legs: list[Leg]) -> None:
        super().__init__(error.what, where=error.where, todo=error.todo)
        self.legs = legs


class Search:
    """A search from the initial state; ``states`` counts the symbolic states stored.

    A state whose zone lies inside that of another one with the same discrete state is not stored, and one that is
    overtaken by a larger one is not expanded: sound for reachability.
    """

    def __init__(self, space: SymbolicSpace) -> None:
        self.space = space
        self.states = 0

    def nodes(self) -> Iterator[Node]:
        """Each symbolic state as it is found.

        Raises:
            OutOfRangeError: a value leaves its range on the way.
        """
        place, zone = self.space.initial()
        first = Node(place, zone, None, None)
        self._store(first)
        waiting = deque([first])
        yield first
        while waiting:
            node = waiting.popleft()
            if node.covered:
                continue
            zone = node.zone
            try:
                steps = node.place.steps
            except RangeError as error:
                raise OutOfRangeError(error, node.legs) from None
            for plan, target, move in steps:
                after = plan(zone)
                if after is None:
                    continue
                if move.error is not None:
                    raise OutOfRangeError(move.error, [*node.legs, Leg(move)])
                if after in target.seen:
                    continue
                for other in target.passed:
                    if all(map(le, after, other.zone)):
                        break
                else:
                    found = Node(target, after, node, move)
                    self._store(found)
                    waiting.append(found)
                    yield found

    def _store(self, node: Node) -> None:
        place, zone = node.place, node.zone
        place.seen.add(zone)
        kept = []
        for other in place.passed:
            if all(map(le, other.zone, zone)):
                other.covered = True
            else:
                kept.append(other)
        kept.append(node)
        place.passed = kept
        self.states += 1

    def first(self, wanted: Callable[[Node], bool]) -> Node | None:
        """The first state that is wanted, by the length of its run; None if there is none."""
        return next((node for node in self.nodes() if wanted(node)), None)
