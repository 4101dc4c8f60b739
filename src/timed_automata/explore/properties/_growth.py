"""Whether a clock has no supremum: a part of a run that can be repeated and adds to the clock each time."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

from timed_automata.explore.search import Search, SearchNode, ZoneCondition
from timed_automata.explore.states import SymbolicSpace
from timed_automata.explore.zones import INFINITY, LARGEST, NEVER, Limit, Zone, below, constrained

_MOST_PARTS = 200  # of a run that are tried


def grows(search: Search, node: SearchNode, clock: int, cases: ZoneCondition) -> bool:
    """Whether the run to a state shows that the clock has no supremum where the condition holds.

    On the run, since the clock was last set, a discrete state comes again, and from the valuations in which the clock
    is past every upper limit all of these are reached again with the clock larger by 1: repeated any number of
    times, the rest of the run still follows, as nothing asks for an upper bound of the clock any more.
    """
    run = _since_set(node, clock)
    upper = max(at.record.limits[clock].upper for at in run)
    limits = search.space.limits.and_also({clock: Limit(LARGEST - 1, NEVER)})  # this clock is not widened
    exact = SymbolicSpace(search.space.discrete, limits)
    for first, again in islice(_parts(run), _MOST_PARTS):
        record = first.record
        index, n = record.index[clock], record.n
        past = () if upper == NEVER else ((0, index, below(-upper)),)
        start = constrained(first.zone, n, past)
        after = start and _follow(exact, start, run[run.index(first) : run.index(again) + 1])
        if start and after and _larger(start, after, index, n):
            end = _follow(exact, after, run[run.index(again) :])
            if end is not None and cases.part(node.record, end) is not None:
                return True
    return False


def _since_set(node: SearchNode, clock: int) -> list[SearchNode]:
    run = [node]
    while run[-1].move is not None and clock not in run[-1].move.resets and run[-1].parent is not None:
        run.append(run[-1].parent)
    return run[::-1]


def _parts(run: list[SearchNode]) -> Iterator[tuple[SearchNode, SearchNode]]:
    """Pairs with the same discrete state, the shortest parts last in the run first."""
    for length in range(1, len(run)):
        for at in range(len(run) - 1, length - 1, -1):
            if run[at].record is run[at - length].record:
                yield run[at - length], run[at]


def _follow(space: SymbolicSpace, zone: Zone, run: list[SearchNode]) -> Zone | None:
    """What becomes of a zone of the first state along the moves of a run."""
    after: Zone | None = zone
    record = space.record(run[0].record.discrete)
    for node in run[1:]:
        assert node.move is not None
        plan, record, _ = space.step(record, node.move)
        after = None if after is None else plan(after)
    return after


def _larger(zone: Zone, later: Zone, index: int, n: int) -> bool:
    """Whether ``later`` holds all of ``zone`` with the clock at ``index`` larger by some k of at least 1."""
    row = range(index * n, index * n + n)
    gains = [(later[at] - zone[at]) >> 1 for at in row if at - index * n != index and zone[at] != INFINITY]
    k = min(gains, default=0)
    if k < 1:
        return False
    for at, (old, new) in enumerate(zip(zone, later, strict=True)):
        wanted = old
        if old != INFINITY and at not in row and at % n == index:
            wanted = old - 2 * k
        elif at in row and at % n != index and old != INFINITY:
            wanted = old + 2 * k
        if new < wanted:
            return False
    return True
