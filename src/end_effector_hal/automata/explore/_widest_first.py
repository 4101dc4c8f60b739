"""A search that follows first what has taken longest: where a worst case is looked for, less is overtaken."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from heapq import heappop, heappush
from operator import le

from end_effector_hal.automata._faults import RangeError
from end_effector_hal.automata.explore._reach import Node, OutOfRangeError, Search
from end_effector_hal.automata.explore._sharp import SharpSpace
from end_effector_hal.automata.explore._symbolic import Shape
from end_effector_hal.automata.explore._zone import Zone

_UNKNOWN: Zone = ()  # what becomes of a zone is not known yet


class WidestFirst(Search):
    """Finds the same states as :class:`Search`, not by the shortest runs.

    Args:
        space: whose equal zones are one object: what was found out about two of them is kept.
        clocks: states in which one of these can be largest are expanded first.
    """

    def __init__(self, space: SharpSpace, clocks: Sequence[int]) -> None:
        super().__init__(space)
        self._clocks = tuple(clocks)
        self._uppers: dict[Shape, list[int]] = {}
        self._inside: dict[Zone, dict[Zone, bool]] = {}

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
                after = plan.known.get(zone, _UNKNOWN)
                if after is _UNKNOWN:
                    after = plan(zone)
                if after is None:
                    continue
                if move.error is not None:
                    raise OutOfRangeError(move.error, [])
                seen = target.seen
                if after in seen:
                    continue
                seen.add(after)
                if self._covered(after, target.passed):
                    continue
                found = Node(target, after, None, None)
                self._store(found)
                heappush(waiting, (self._rank(target.shape, after), self.states, found))
                yield found

    def _covered(self, zone: Zone, others: list[Node]) -> bool:
        """Whether a zone lies inside that of a node."""
        inside = self._inside.get(zone)
        if inside is None:
            inside = self._inside[zone] = {}
        for other in others:
            outer = other.zone
            within = inside.get(outer)
            if within is None:
                within = inside[outer] = all(map(le, zone, outer))
            if within:
                return True
        return False

    def _store(self, node: Node) -> None:
        place = node.place
        if place.passed:
            only, kept = [node], []
            for other in place.passed:
                if self._covered(other.zone, only):
                    other.covered = True
                else:
                    kept.append(other)
            kept.append(node)
            place.passed = kept
        else:
            place.passed = [node]
        self.states += 1

    def _rank(self, shape: Shape, zone: Zone) -> int:
        """Lower first. Where none of the clocks runs yet comes before all else: it leads to where they do."""
        uppers = self._uppers.get(shape)
        if uppers is None:
            index, n = shape.index, shape.n
            uppers = self._uppers[shape] = [index[clock] * n for clock in self._clocks if clock in index]
        return -max([zone[at] for at in uppers]) if uppers else -1 << 60
