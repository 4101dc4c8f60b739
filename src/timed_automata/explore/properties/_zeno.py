"""Finds cycles on which no time needs to pass.

An infinite run in finite time takes some transitions infinitely often. From some point on less than one unit of time
is left, so no clock can both be set to 0 and be tested for at least 1 again and again (Tripakis, *Verifying Progress
in Timed Systems*, 1999, strong non-Zenoness; applied here to the discrete states that are reached, so that counters
and levels count too). If no set of transitions with that property contains a cycle, time diverges in every infinite
run.

For every clock, a cycle that needs no time omits either all tests of the clock or all its settings to 0. A transition
that is neither on a cycle without the tests nor on one without the settings of some clock can be removed. This takes
two searches for strongly connected components per clock. Only a component from which nothing can be removed is split
into the two cases.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from timed_automata.compiler import Bound
from timed_automata.explore.search import Search
from timed_automata.explore.search._concrete import Leg, NoRunError, anywhere, concrete
from timed_automata.explore.search._cycles import components, shortest_cycle
from timed_automata.explore.states import Move, StateRecord
from timed_automata.explore.states._discrete import Action
from timed_automata.network import Trace

Taken = tuple[StateRecord, StateRecord, Move]  # from, to, by


def taken(records: Iterable[StateRecord]) -> Iterator[Taken]:
    """Yield the transitions that a search has taken."""
    for record in records:
        zones = [node.zone for node in record.passed]
        for plan, target, move in record.steps if zones else ():
            for zone in zones:
                if plan(zone) is not None:
                    yield record, target, move
                    break


def zeno_run(search: Search, arcs: list[Taken]) -> Trace | None:
    """Return a run to a cycle on which no time needs to pass, and once round it; needs a completed search."""
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
    """A transition that was taken, with the clocks tested for at least 1, set to 0, and set to other values."""

    source: StateRecord
    target: StateRecord
    move: Move
    tested: frozenset[int]
    zeroed: frozenset[int]
    set: frozenset[int]


def _marks(
    action: Action, invariant: tuple[Bound, ...]
) -> tuple[frozenset[int], frozenset[int], frozenset[int]]:
    """Return the clocks tested, set to 0 and set otherwise by an action; the target's invariant also tests unset
    clocks.
    """
    kept = (bound for bound in invariant if bound.clock not in action.resets)
    tested = frozenset(
        clock for clock, op, value in (*action.guard, *kept) if op in (">=", ">", "==") and value >= 1
    )
    zeroed = frozenset(clock for clock, value in action.resets.items() if not value)
    return tested, zeroed, frozenset(action.resets) - zeroed


def zeno_cycle(taken: Sequence[Taken]) -> list[Arc] | None:
    """Return a shortest cycle through one state on which no time needs to pass, or None if there is none."""
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
    """Return the clocks that are both tested and set to 0; a clock that is set to other values proves nothing."""
    tested = frozenset[int]().union(*(arc.tested for arc in arcs))
    zeroed = frozenset[int]().union(*(arc.zeroed for arc in arcs))
    return (tested & zeroed) - frozenset[int]().union(*(arc.set for arc in arcs))


def _cases(arcs: list[Arc], clock: int) -> tuple[list[Arc], list[Arc]]:
    """Return the arcs without tests of a clock, and the arcs without its settings to 0."""
    untested = [arc for arc in arcs if clock not in arc.tested]
    return untested, [arc for arc in arcs if clock not in arc.zeroed]


def _thinned(arcs: list[Arc], clock: int) -> list[Arc]:
    """Return the arcs that are on a cycle without tests of a clock, or on one without its settings to 0."""
    untested, unset = map(_numbered, _cases(arcs, clock))
    return [
        arc
        for arc in arcs
        if (clock not in arc.tested and untested[arc.source] == untested[arc.target] is not None)
        or (clock not in arc.zeroed and unset[arc.source] == unset[arc.target] is not None)
    ]


def _numbered(arcs: list[Arc]) -> Mapping[StateRecord, int | None]:
    """Return the number of the component of every state on a cycle; None for a state on no cycle."""
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
    """Repeatedly remove transitions that cannot be on a cycle; in most networks few or none remain."""
    while True:
        sources = {source for source, _, _ in taken}
        left = [one for one in taken if one[1] in sources]
        targets = {target for _, target, _ in left}
        left = [one for one in left if one[0] in targets]
        if len(left) == len(taken):
            return left
        taken = left


def _strong(arcs: list[Arc]) -> Iterable[list[Arc]]:
    """Return the arcs inside every strongly connected component."""
    number = _numbered(arcs)
    parts: dict[int, list[Arc]] = {}
    for one in arcs:
        at = number[one.source]
        if at is not None and at == number[one.target]:
            parts.setdefault(at, []).append(one)
    return parts.values()


def _cycle(arcs: list[Arc]) -> list[Arc]:
    """Return a shortest cycle through the source of the first arc; all arcs belong to one component."""
    following: dict[StateRecord, list[tuple[Arc, StateRecord]]] = {}
    for one in arcs:
        following.setdefault(one.source, []).append((one, one.target))
    return shortest_cycle(arcs[0].source, following.__getitem__)
