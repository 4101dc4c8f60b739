"""Cycles on which no time needs to pass.

An infinite run in finite time takes some transitions infinitely often. From some point on less than one unit of time
is left, so no clock can both be set to 0 and be tested for at least 1 again and again (Tripakis, *Verifying Progress
in Timed Systems*, 1999, strong non-Zenoness; here on the discrete states that are reached, so that counters and
levels count too). If no set of transitions with that property contains a cycle, time diverges in every infinite run.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from typing import NamedTuple

from end_effector_hal.automata.explore._components import components
from end_effector_hal.automata.explore._discrete import Move
from end_effector_hal.automata.explore._symbolic import Place


class Arc(NamedTuple):
    """A transition that was taken: clocks tested for at least 1, clocks set to 0, clocks set to something else."""

    source: Place
    target: Place
    move: Move
    tested: frozenset[int]
    zeroed: frozenset[int]
    set: frozenset[int]


def arc(source: Place, target: Place, move: Move) -> Arc:
    """The arc of a move."""
    tested = frozenset(clock for clock, op, value in move.guard if op in (">=", ">", "==") and value >= 1)
    zeroed = frozenset(clock for clock, value in move.resets.items() if not value)
    return Arc(source, target, move, tested, zeroed, frozenset(move.resets) - zeroed)


def zeno_cycle(arcs: Iterable[Arc]) -> list[Arc] | None:
    """A cycle on which no time needs to pass, the shortest of its kind through one state; None if there is none."""
    pending = [list(arcs)]
    while pending:
        for part in _strong(pending.pop()):
            blind = frozenset[int]().union(
                *(arc.set for arc in part)
            )  # a clock set to something else says nothing
            alone = [arc for arc in part if not (arc.tested & arc.zeroed) - blind]
            if len(alone) < len(part):
                pending.append(alone)
                continue
            tested = frozenset[int]().union(*(arc.tested for arc in part))
            zeroed = frozenset[int]().union(*(arc.zeroed for arc in part))
            both = (tested & zeroed) - blind
            if not both:
                return _cycle(part)
            clock = min(both)
            pending.append([arc for arc in part if clock not in arc.tested])
            pending.append([arc for arc in part if clock not in arc.zeroed])
    return None


def _strong(arcs: list[Arc]) -> Iterable[list[Arc]]:
    """The arcs inside each strongly connected component."""
    graph: dict[Place, list[Place]] = {}
    for one in arcs:
        graph.setdefault(one.source, []).append(one.target)
        graph.setdefault(one.target, [])
    number = {place: at for at, component in enumerate(components(graph)) for place in component}
    parts: dict[int, list[Arc]] = {}
    for one in arcs:
        at = number.get(one.source)
        if at is not None and at == number.get(one.target):
            parts.setdefault(at, []).append(one)
    return parts.values()


def _cycle(arcs: list[Arc]) -> list[Arc]:
    """A shortest cycle through the source of the first arc; all arcs belong to one component."""
    following: dict[Place, list[Arc]] = {}
    for one in arcs:
        following.setdefault(one.source, []).append(one)
    start = arcs[0].source
    came: dict[Place, Arc] = {}
    waiting = deque([start])
    while start not in came:
        for one in following[waiting.popleft()]:
            if one.target not in came:
                came[one.target] = one
                waiting.append(one.target)
    cycle = [came[start]]
    while cycle[-1].source is not start:
        cycle.append(came[cycle[-1].source])
    return cycle[::-1]
