"""A naive explorer that shares nothing with the one under test: the region graph of Alur and Dill (1994).

Exact for strict and closed constraints alike, and for deadlock and liveness. A clock is its integer part and the
rank of its fraction among the fractions of all clocks (0: none), or BEYOND every constant. Transitions are made from
the edges anew, not by ``Semantics``.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from itertools import product
from typing import NamedTuple

from timed_automata import Network
from timed_automata.network import Edge

BEYOND = (-1, 0)


class Region(NamedTuple):
    locations: tuple[int, ...]
    values: tuple[int, ...]
    clocks: tuple[tuple[int, int], ...]  # of clock 1, 2, …


Predicate = Callable[[Region], bool]


def compare(clock: tuple[int, int], op: str, value: int) -> bool:
    if clock == BEYOND:
        return op in (">", ">=")
    whole, rank = clock
    if op in ("<", ">="):
        return (whole < value) is (op == "<")
    if op in ("<=", ">"):
        return (whole < value or (whole == value and not rank)) is (op == "<=")
    return whole == value and not rank


class Regions:
    def __init__(self, network: Network, largest: int) -> None:
        self.network, self.largest = network, largest
        start = network.initial
        self.initial = Region(start.locations, start.values, ((0, 0),) * (len(network.clocks) - 1))

    # Semantics

    def _satisfied(self, condition: object, region: Region) -> bool:
        if condition.never or (condition.data and not condition.data(region.values)):  # type: ignore[attr-defined]
            return False
        for constraint in condition.clocks:  # type: ignore[attr-defined]
            clock, op, value = constraint.at(region.values)
            if not compare(region.clocks[clock - 1], op, value):
                return False
        return True

    def invariant(self, region: Region) -> bool:
        processes = zip(self.network.processes, region.locations, strict=True)
        return all(self._satisfied(process.locations[at].invariant, region) for process, at in processes)

    def _enabled(self, region: Region) -> Iterator[tuple[Edge, ...]]:
        ready = [
            [edge for edge in process.edges if edge.source == at and self._satisfied(edge.guard, region)]
            for process, at in zip(self.network.processes, region.locations, strict=True)
        ]

        def on(edge: Edge) -> int:
            return edge.channel if isinstance(edge.channel, int) else edge.channel(region.values)  # type: ignore

        for number, edges in enumerate(ready):
            for edge in edges:
                if edge.direction == "":
                    yield (edge,)
                if edge.direction != "!":
                    continue
                answers = [
                    [e for e in others if e.direction == "?" and on(e) == on(edge)] if other != number else []
                    for other, others in enumerate(ready)
                ]
                if self.network.channels[on(edge)].broadcast:
                    yield from ((edge, *chosen) for chosen in product(*(a for a in answers if a)))
                else:
                    yield from ((edge, answer) for several in answers for answer in several)

    def transitions(self, region: Region) -> Iterator[tuple[Edge, ...]]:
        stopped = [
            p.locations[at].committed for p, at in zip(self.network.processes, region.locations, strict=True)
        ]
        for edges in self._enabled(region):
            if not any(stopped) or any(stopped[edge.process] for edge in edges):
                yield edges

    def actions(self, region: Region) -> list[Region]:
        found = []
        for edges in self.transitions(region):
            locations, values, clocks = list(region.locations), list(region.values), list(region.clocks)
            resets: list[tuple[int, int]] = []
            for edge in edges:
                locations[edge.process] = edge.target
                if edge.update:
                    edge.update(values, resets)
            for clock, value in resets:
                clocks[clock - 1] = (value, 0) if value <= self.largest else BEYOND
            after = Region(tuple(locations), tuple(values), self._canonical(clocks))
            if self.invariant(after):
                found.append(after)
        return found

    def later(self, region: Region) -> Region | None:
        """The next region in time, itself if all clocks are beyond; None if time must not pass."""
        for process, at in zip(self.network.processes, region.locations, strict=True):
            if process.locations[at].urgent or process.locations[at].committed:
                return None
        for edges in self._enabled(region):
            channel = edges[0].channel
            if channel is not None:
                number = channel if isinstance(channel, int) else channel(region.values)
                if self.network.channels[number].urgent:
                    return None
        after = Region(region.locations, region.values, self._pass(region.clocks))
        return after if self.invariant(after) else None

    def _canonical(self, clocks: list[tuple[int, int]]) -> tuple[tuple[int, int], ...]:
        return ranked(clocks)

    def _pass(self, clocks: tuple[tuple[int, int], ...]) -> tuple[tuple[int, int], ...]:
        finite = [rank for clock in clocks if clock != BEYOND for _, rank in [clock]]
        if not finite:
            return clocks
        if 0 in finite:
            moved = [
                clock if clock == BEYOND or rank else (BEYOND if whole == self.largest else (whole, -1))
                for clock in clocks
                for whole, rank in [clock]
            ]
        else:
            moved = [
                clock if clock == BEYOND or rank < max(finite) else (whole + 1, 0)
                for clock in clocks
                for whole, rank in [clock]
            ]
        return ranked(moved)

    # Properties

    def reachable(self) -> set[Region]:
        return self._closure({self.initial}, lambda _: True)

    def _closure(self, start: set[Region], inside: Predicate) -> set[Region]:
        seen = {region for region in start if inside(region)}
        waiting = deque(seen)
        while waiting:
            region = waiting.popleft()
            later = self.later(region)
            for after in [*self.actions(region), *([later] if later else [])]:
                if after not in seen and inside(after):
                    seen.add(after)
                    waiting.append(after)
        return seen

    def deadlocked(self, region: Region) -> bool:
        seen = set()
        at: Region | None = region
        while at is not None and at not in seen:
            if self.actions(at):
                return False
            seen.add(at)
            at = self.later(at)
        return True

    def stays(self, start: set[Region], inside: Predicate) -> bool:
        """Whether a run from one of the regions stays inside: without end, or to where nothing is possible."""
        graph = {}
        for region in self._closure(start, inside):
            later, actions = self.later(region), self.actions(region)
            if later is None and not actions:
                return True
            graph[region] = [r for r in [*actions, *([later] if later else [])] if inside(r)]
        while True:
            ended = {region for region, after in graph.items() if not any(r in graph for r in after)}
            if not ended:
                return bool(graph)
            for region in ended:
                del graph[region]


class Sampled(Regions):
    """The same with time in quarters: a pause is as long whatever clocks there are, also one that nobody asks for.

    The second number of a clock is its quarters, not a rank. With two clocks no order of fractions is left out.
    """

    def _canonical(self, clocks: list[tuple[int, int]]) -> tuple[tuple[int, int], ...]:
        return tuple(clocks)

    def _pass(self, clocks: tuple[tuple[int, int], ...]) -> tuple[tuple[int, int], ...]:
        return tuple(
            BEYOND
            if clock == BEYOND or clock[0] >= self.largest
            else (clock[0] + (clock[1] == 3), (clock[1] + 1) % 4)
            for clock in clocks
        )


def ranked(clocks: list[tuple[int, int]]) -> tuple[tuple[int, int], ...]:
    """Fractions as ranks 1, 2, … without gaps; -1 is smaller than all that are there."""
    ranks = sorted({rank for clock in clocks if clock != BEYOND for _, rank in [clock] if rank})
    return tuple(
        clock if clock == BEYOND or not rank else (whole, ranks.index(rank) + 1)
        for clock in clocks
        for whole, rank in [clock]
    )
