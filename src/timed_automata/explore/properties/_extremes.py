"""Suprema and infima: how large or small a clock or an integer gets where a condition holds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from timed_automata.explore.properties._growth import grows
from timed_automata.explore.properties._verdict import Extreme
from timed_automata.explore.search import Ending, Progress, Search, SearchNode, ZoneCondition
from timed_automata.explore.states import DiscreteSpace, StateRecord, SymbolicSpace
from timed_automata.explore.zones import (
    INFINITY,
    NEVER,
    Limit,
    Limits,
    Zone,
    at_most,
    below,
    constrained,
    largest,
    limits_of,
    merged,
)
from timed_automata.queries import Formula

MOST = 1 << 24  # a supremum beyond is called unbounded (4.6 hours in milliseconds)


@dataclass(frozen=True, slots=True)
class FoundExtreme:
    """An extreme, where it is (None: nowhere), and the part of a zone there that shows it."""

    extreme: Extreme
    search: Search
    node: SearchNode | None
    ending: Ending


Read = Callable[[tuple[int, ...], tuple[int, ...]], int]


def extreme_integer(
    discrete: DiscreteSpace, condition: Formula, read: Read, *, upper: bool, progress: Progress | None = None
) -> FoundExtreme:
    """The extreme of an integer expression.

    Raises:
        OutOfRangeError: a value leaves its range on the way.
    """
    search, cases = (
        Search(SymbolicSpace(discrete, Limits(discrete.network, limits_of(condition))), progress),
        ZoneCondition(condition),
    )
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
    """The extreme of a clock. Zones are exact up to its limits, which are doubled until the extreme lies below.

    Raises:
        OutOfRangeError: a value leaves its range on the way.
    """
    limit = max(1, largest(discrete.network))
    while True:
        extra = {clock: Limit(limit, NEVER) if upper else Limit(NEVER, limit)}
        merged(extra, limits_of(condition))
        search = Search(SymbolicSpace(discrete, Limits(discrete.network, extra)), progress)
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
        """The extreme; None if it lies beyond the limit."""
        best, where = -INFINITY, None
        for node in self.search.nodes():
            bound = self._bound(node)
            if bound == INFINITY or (self.upper and bound > at_most(self.limit)):
                endless = bound == INFINITY and self._endless(node)
                if endless or grows(self.search, node, self.clock, self.cases):
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
        """The bound of the clock, upper or negated lower; the larger the more extreme."""
        record, n = node.record, node.record.n
        index, best = record.index[self.clock], -INFINITY
        for constraints, _ in self.cases.of(record):
            part = constrained(node.zone, n, constraints)
            if part is not None:
                best = max(best, part[index * n] if self.upper else part[index])
        return best

    def _endless(self, node: SearchNode) -> bool:
        """Whether time can pass without end where the condition holds."""
        discrete = node.record.discrete
        if not discrete.delays or discrete.invariant:
            return False
        return any(all(j for _, j, _ in constraints) for constraints, _ in self.cases.of(node.record))

    def _ending(self, value: int, attained: bool) -> Ending:
        """The extreme itself, or close to it."""
        if self.upper:
            bound = at_most(-value) if attained else below(1 - value)
        else:
            bound = at_most(value) if attained else below(value + 1)

        def ending(record: StateRecord, zone: Zone) -> Zone | None:
            index = record.index[self.clock]
            wanted = (0, index, bound) if self.upper else (index, 0, bound)
            for constraints, _ in self.cases.of(record):
                part = constrained(zone, record.n, (*constraints, wanted))
                if part is not None:
                    return part
            return None

        return ending

    def unbounded(self, node: SearchNode | None) -> FoundExtreme:
        """No supremum."""
        return FoundExtreme(Extreme(None, attained=False), self.search, node, self.cases.part)
