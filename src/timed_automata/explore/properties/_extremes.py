"""Suprema and infima: the largest and smallest value of a clock or an integer where a condition holds."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import islice

from timed_automata.explore.properties._verdict import Extreme
from timed_automata.explore.search import Search
from timed_automata.explore.search._concrete import Ending
from timed_automata.explore.search._conditions import ZoneCondition
from timed_automata.explore.search._reach import Progress
from timed_automata.explore.search._stages import SearchNode
from timed_automata.explore.states import DiscreteSpace, StateRecord, SymbolicSpace
from timed_automata.explore.zones import INFINITY, Limit, Limits, Zone, constrained
from timed_automata.explore.zones._limits import NEVER, QueryLimits, largest, limits_of, merged
from timed_automata.explore.zones._zone import LARGEST, at_most, below
from timed_automata.queries import Formula

MOST = 1 << 24  # a supremum beyond is called unbounded (4.6 hours in milliseconds)
_MOST_PARTS = 200  # of a run that are tried


@dataclass(frozen=True, slots=True)
class FoundExtreme:
    """An extreme, the node where it occurs (None if it occurs nowhere), and the part of the zone that shows it."""

    extreme: Extreme
    search: Search
    node: SearchNode | None
    ending: Ending


Read = Callable[[tuple[int, ...], tuple[int, ...]], int]


def extreme_integer(
    discrete: DiscreteSpace, condition: Formula, read: Read, *, upper: bool, progress: Progress | None = None
) -> FoundExtreme:
    """Find the extreme of an integer expression.

    Raises:
        OutOfRangeError: a value leaves its range on the way.
    """
    cases, limits = ZoneCondition(condition), Limits(discrete.network, [QueryLimits(limits_of(condition))])
    search = Search(SymbolicSpace(discrete, limits), progress)
    best, where = None, None
    for node in search.nodes():
        state = node.record.discrete.state
        value = read(state.values, state.locations)
        if best is not None and (value <= best if upper else value >= best):
            continue
        if cases.part(node.record, node.zone) is not None:
            best, where = value, node
    return FoundExtreme(Extreme(best, attained=True), search, where, cases.part)


def extreme_clock(
    discrete: DiscreteSpace, condition: Formula, clock: int, *, upper: bool, progress: Progress | None = None
) -> FoundExtreme:
    """Find the extreme of a clock. Zones are exact up to the clock's limits, which are doubled until the extreme lies
    below.

    Raises:
        OutOfRangeError: a value leaves its range on the way.
    """
    limit = max(1, largest(discrete.network))
    while True:
        extra = {clock: Limit(limit, NEVER) if upper else Limit(NEVER, limit)}
        merged(extra, limits_of(condition))
        search = Search(SymbolicSpace(discrete, Limits(discrete.network, [QueryLimits(extra)])), progress)
        attempt = _Attempt(search, ZoneCondition(condition), clock, upper, limit)
        found = attempt.run()
        if found is not None:
            return found
        if limit >= MOST:
            return attempt.unbounded(None)
        limit *= 2


@dataclass(frozen=True, slots=True)
class _Attempt:
    search: Search
    cases: ZoneCondition
    clock: int
    upper: bool
    limit: int

    def run(self) -> FoundExtreme | None:
        """Return the extreme, or None if it lies beyond the limit."""
        best, where = -INFINITY, None
        for node in self.search.nodes():
            bound = self._bound(node)
            if bound == INFINITY or (self.upper and bound > at_most(self.limit)):
                endless = bound == INFINITY and self._endless(node)
                if endless or _grows(self.search, node, self.clock, self.cases):
                    return self.unbounded(node)
                return None
            if bound > best:
                best, where = bound, node
        if where is None:
            return FoundExtreme(Extreme(None, attained=True), self.search, None, self.cases.part)
        if not self.upper and best <= below(-self.limit):
            return None
        value, attained = (best >> 1 if self.upper else -(best >> 1)), bool(best & 1)
        return FoundExtreme(Extreme(value, attained), self.search, where, self._ending(value, attained))

    def _bound(self, node: SearchNode) -> int:
        """Return the bound of the clock, upper or negated lower; a larger bound is more extreme."""
        record, n = node.record, node.record.n
        index, best = record.form.index[self.clock], -INFINITY
        for constraints, _ in self.cases.of(record):
            part = constrained(node.zone, n, constraints)
            if part is not None:
                best = max(best, part[index * n] if self.upper else part[index])
        return best

    def _endless(self, node: SearchNode) -> bool:
        """Return whether time can pass without end where the condition holds."""
        if not node.record.discrete.endless:
            return False
        return any(all(j for _, j, _ in constraints) for constraints, _ in self.cases.of(node.record))

    def _ending(self, value: int, attained: bool) -> Ending:
        """Return an ending that requires the extreme itself, or a value within one unit of it."""
        if self.upper:
            bound = at_most(-value) if attained else below(1 - value)
        else:
            bound = at_most(value) if attained else below(value + 1)

        def ending(record: StateRecord, zone: Zone) -> Zone | None:
            index = record.form.index[self.clock]
            wanted = (0, index, bound) if self.upper else (index, 0, bound)
            for constraints, _ in self.cases.of(record):
                part = constrained(zone, record.n, (*constraints, wanted))
                if part is not None:
                    return part
            return None

        return ending

    def unbounded(self, node: SearchNode | None) -> FoundExtreme:
        """Return the result that there is no supremum."""
        return FoundExtreme(Extreme(None, attained=False), self.search, node, self.cases.part)


def _grows(search: Search, node: SearchNode, clock: int, cases: ZoneCondition) -> bool:
    """Return whether the run to a state shows that the clock has no supremum where the condition holds.

    The run must repeat a discrete state since the clock was last set. From the valuations in which the clock is past
    every upper limit, the repetition must reach all of these again with the clock larger by at least 1. Then it can be
    repeated any number of times, and the rest of the run still follows, because no later constraint has an upper bound
    on the clock.
    """
    run = _since_set(node, clock)
    upper = max(at.record.form.limits[clock].upper for at in run)
    limits = search.space.limits.and_also({clock: Limit(LARGEST - 1, NEVER)})  # this clock is not widened
    exact = SymbolicSpace(search.space.discrete, limits)
    for first, again in islice(_parts(run), _MOST_PARTS):
        record = first.record
        index, n = record.form.index[clock], record.n
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
    while run[-1].move is not None and clock not in run[-1].move.action.resets and run[-1].parent is not None:
        run.append(run[-1].parent)
    return run[::-1]


def _parts(run: list[SearchNode]) -> Iterator[tuple[SearchNode, SearchNode]]:
    """Yield pairs of nodes with the same discrete state: short distances first, and among these the latest first."""
    for length in range(1, len(run)):
        for at in range(len(run) - 1, length - 1, -1):
            if run[at].record is run[at - length].record:
                yield run[at - length], run[at]


def _follow(space: SymbolicSpace, zone: Zone, run: list[SearchNode]) -> Zone | None:
    """Return the zone that results from a zone of the first state after the moves of a run."""
    after: Zone | None = zone
    record = space.record(run[0].record.discrete)
    for node in run[1:]:
        assert node.move is not None
        plan, record, _ = space.step(record, node.move)
        after = None if after is None else plan(after)
    return after


def _larger(zone: Zone, later: Zone, index: int, n: int) -> bool:
    """Return whether ``later`` contains all of ``zone`` with the clock at ``index`` larger by some k of at least 1."""
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
