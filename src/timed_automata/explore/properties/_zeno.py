"""Cycles on which no time needs to pass.

An infinite run in finite time takes some transitions infinitely often. From some point on less than one unit of time
is left, so no clock can both be set to 0 and be tested for at least 1 again and again (Tripakis, *Verifying Progress
in Timed Systems*, 1999, strong non-Zenoness; here on the discrete states that are reached, so that counters and
levels count too). If no set of transitions with that property contains a cycle, time diverges in every infinite run.

For each clock a cycle leaves out all its tests or all its settings to 0. A transition that is on a cycle neither
without the tests nor without the settings of one clock is on no such cycle: to leave those out, clock by clock, takes
two searches for components for each clock. Only what this cannot thin out is divided into the two cases.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from timed_automata.compiler import Bound
from timed_automata.explore.search import (
    Leg,
    NoRunError,
    Search,
    anywhere,
    components,
    concrete,
    shortest_cycle,
)
from timed_automata.explore.states import Action, Move, StateRecord
from timed_automata.network import Trace

Taken = tuple[StateRecord, StateRecord, Move]  # from, to, by


def taken(records: Iterable[StateRecord]) -> Iterator[Taken]:
    """The transitions that a search has taken."""
    for record in records:
        zones = [node.zone for node in record.passed]
        for plan, target, move in record.steps if zones else ():
            for zone in zones:
                if plan(zone) is not None:
                    yield record, target, move
                    break


def zeno_run(search: Search, arcs: list[Taken]) -> Trace | None:
    """A run to a cycle on which no time needs to pass, and once round, after a whole search."""
    cycle = zeno_cycle(arcs)
    if cycle is None:
        return None
    moves = [Leg(Move(one.move.action, one.target.discrete)) for one in cycle]
    remark = "a cycle on which no time needs to pass"
    for node in cycle[0].source.passed:
        try:
            loop = len(node.legs) - 1
            return concrete(search.space, [*node.legs, *moves], anywhere, remark, loop=loop)
        except NoRunError:  # not from this zone
            continue
    return concrete(search.space, cycle[0].source.passed[0].legs, anywhere, f"here begins {remark}")


class Arc(NamedTuple):
    """A transition that was taken: clocks tested for at least 1, clocks set to 0, clocks set to something else."""

    source: StateRecord
    target: StateRecord
    move: Move
    tested: frozenset[int]
    zeroed: frozenset[int]
    set: frozenset[int]


def _marks(
    action: Action, invariant: tuple[Bound, ...]
) -> tuple[frozenset[int], frozenset[int], frozenset[int]]:
    """Of an action that leads to where an invariant holds: its lower bounds test what is not set on the way."""
    kept = (bound for bound in invariant if bound.clock not in action.resets)
    tested = frozenset(
        clock for clock, op, value in (*action.guard, *kept) if op in (">=", ">", "==") and value >= 1
    )
    zeroed = frozenset(clock for clock, value in action.resets.items() if not value)
    return tested, zeroed, frozenset(action.resets) - zeroed


def zeno_cycle(taken: Sequence[Taken]) -> list[Arc] | None:
    """A cycle on which no time needs to pass, the shortest of its kind through one state; None if there is none."""
    kinds = [(move.action, target.form.entry) for _, target, move in taken]
    marks = {kind: _marks(*kind) for kind in set(kinds)}
    blind = frozenset[int]().union(*(free for _, _, free in marks.values()))
    slow = {kind for kind, (tested, zeroed, _) in marks.items() if (tested & zeroed) - blind}
    quick = _round([one for one, kind in zip(taken, kinds, strict=True) if kind not in slow])
    pending = [
        [Arc(source, target, move, *marks[move.action, target.form.entry]) for source, target, move in quick]
    ]
    while pending:
        for part in _strong(pending.pop()):
            clocks = _opposed(part)
            if not clocks:
                return _cycle(part)
            thin = part
            for clock in sorted(clocks):
                thin = _thinned(thin, clock)
            pending += [thin] if len(thin) < len(part) else _cases(part, min(clocks))
    return None


def _opposed(arcs: list[Arc]) -> frozenset[int]:
    """The clocks that are both tested and set to 0; one that is set to something else says nothing."""
    tested = frozenset[int]().union(*(arc.tested for arc in arcs))
    zeroed = frozenset[int]().union(*(arc.zeroed for arc in arcs))
    return (tested & zeroed) - frozenset[int]().union(*(arc.set for arc in arcs))


def _cases(arcs: list[Arc], clock: int) -> tuple[list[Arc], list[Arc]]:
    """Without the tests of a clock, and without its settings to 0."""
    untested = [arc for arc in arcs if clock not in arc.tested]
    return untested, [arc for arc in arcs if clock not in arc.zeroed]


def _thinned(arcs: list[Arc], clock: int) -> list[Arc]:
    """The arcs that are on a cycle without the tests of a clock, or on one without its settings to 0."""
    untested, unset = map(_numbered, _cases(arcs, clock))
    return [
        arc
        for arc in arcs
        if (clock not in arc.tested and untested[arc.source] == untested[arc.target] is not None)
        or (clock not in arc.zeroed and unset[arc.source] == unset[arc.target] is not None)
    ]


def _numbered(arcs: list[Arc]) -> Mapping[StateRecord, int | None]:
    """The component of each state that is on a cycle, as a number; None: it is on none."""
    graph: dict[StateRecord, list[StateRecord]] = {one.target: [] for one in arcs}
    for one in arcs:
        following = graph.get(one.source)
        if following is None:
            graph[one.source] = [one.target]
        else:
            following.append(one.target)
    number: dict[StateRecord, int | None] = dict.fromkeys(graph)
    for at, component in enumerate(components(graph)):
        for record in component:
            number[record] = at
    return number


def _round(taken: list[Taken]) -> list[Taken]:
    """Without what leads nowhere, again and again: what is left of most networks is little, or nothing."""
    while True:
        sources = {source for source, _, _ in taken}
        left = [one for one in taken if one[1] in sources]
        targets = {target for _, target, _ in left}
        left = [one for one in left if one[0] in targets]
        if len(left) == len(taken):
            return left
        taken = left


def _strong(arcs: list[Arc]) -> Iterable[list[Arc]]:
    """The arcs inside each strongly connected component."""
    number = _numbered(arcs)
    parts: dict[int, list[Arc]] = {}
    for one in arcs:
        at = number[one.source]
        if at is not None and at == number[one.target]:
            parts.setdefault(at, []).append(one)
    return parts.values()


def _cycle(arcs: list[Arc]) -> list[Arc]:
    """A shortest cycle through the source of the first arc; all arcs belong to one component."""
    following: dict[StateRecord, list[tuple[Arc, StateRecord]]] = {}
    for one in arcs:
        following.setdefault(one.source, []).append((one, one.target))
    return shortest_cycle(arcs[0].source, following.__getitem__)
