"""Judges responses during an exploration of all states: bounded ones, and ``p --> q``."""

from __future__ import annotations

from dataclasses import replace

from timed_automata.explore.properties._verdict import Extreme
from timed_automata.explore.search._conditions import Only, Within, ZoneCondition
from timed_automata.explore.search._liveness import LassoSearch, Start
from timed_automata.explore.search._reach import Progress
from timed_automata.explore.search._stages import SearchNode
from timed_automata.explore.states import SymbolicSpace
from timed_automata.explore.zones import INFINITY, Limit, constrained
from timed_automata.explore.zones._limits import NEVER, limits_of, merged
from timed_automata.explore.zones._zone import at_most, below
from timed_automata.language import ast
from timed_automata.network import Network
from timed_automata.queries import (
    Formula,
    Query,
    compile_clock,
    compile_formula,
    compile_integer,
    compile_without_deadlock,
    mentions_deadlock,
)


class BoundedResponse:
    """The query ``A[] p imply x <= c``: p never lasts longer than c since x was set. Also keeps the largest x seen.

    Attributes:
        clock: its number.
        most: the bound, a constant.
        premise: the condition under which the bound must hold.
        limits: limits of clocks that the zones must keep.
    """

    def __init__(self, premise: Formula, clock: int, most: int, *, strict: bool) -> None:
        self.clock, self.most = clock, most
        self.limits = {clock: Limit(max(most, 0), NEVER)}
        merged(self.limits, limits_of(premise))
        self.premise = premise
        self._cases = ZoneCondition(premise)
        self._bound = below(most) if strict else at_most(most)
        self._largest = -INFINITY

    def add(self, node: SearchNode) -> None:
        """Include a symbolic state in the result."""
        record, n = node.record, node.record.n
        at = record.form.index[self.clock] * n
        for constraints, _ in self._cases.of(record):
            part = constrained(node.zone, n, constraints)
            if part is not None and part[at] > self._largest:
                self._largest = part[at]

    def forget(self) -> None:
        """Drop the cached data of the states seen; the results stay."""
        self._cases.forget()

    @property
    def holds(self) -> bool:
        """Whether the bound held in all states seen."""
        return self._largest <= self._bound

    @property
    def met(self) -> bool:
        """Whether the premise held in any state seen."""
        return self._largest != -INFINITY

    @property
    def longest(self) -> Extreme | None:
        """The supremum of the clock, or None if it lies beyond the bound."""
        if not self.met:
            return Extreme(None, attained=True)
        return Extreme(self._largest >> 1, bool(self._largest & 1)) if self.holds else None

    @property
    def at_least(self) -> int:
        """A value that the clock reaches or exceeds, exact up to the bound; -1 if the premise held nowhere."""
        return min(self._largest >> 1, self.most) if self.met else -1


def bounded(network: Network, query: Query) -> BoundedResponse | None:
    """Return a query as a bounded response, or None if it is something else.

    Raises:
        ModelError: the query is not well-formed.
    """
    match query:
        case Query(
            kind="A[]",
            condition=ast.Binary(
                op="imply", left=premise, right=ast.Binary(op="<=" | "<" as op, left=left, right=right)
            ),
        ):
            if not isinstance(left, ast.Name | ast.Member) or not _is_constant(network, right):
                return None
            clock, formula = compile_clock(network, left), compile_formula(network, premise)
            if clock is None or mentions_deadlock(formula):
                return None
            most = compile_integer(network, right)(network.initial.values, network.initial.locations)
            return BoundedResponse(formula, clock, most, strict=op == "<")
    return None


def relaxed(query: Query, most: int) -> Query:
    """Return a bounded response with another bound."""
    match query.condition:
        case ast.Binary(op="imply", right=ast.Binary() as bound):
            wider = replace(bound, op="<=", right=ast.Number(bound.right.span, most))
            return replace(query, condition=replace(query.condition, right=wider))
    raise AssertionError(f"'{query}' is no bounded response")


def _is_constant(network: Network, node: ast.Expression) -> bool:
    if isinstance(node, ast.Name):
        return node.name in network.constants
    return isinstance(node, ast.Number)


class LeadsTo:
    """The query ``p --> q``, decided from the states of p and those that follow them.

    Attributes:
        limits: limits of clocks that the zones must keep.
        premise: p.
        met: whether p held anywhere.
        holds: whether q follows.
    """

    def __init__(self, network: Network, query: Query) -> None:
        assert query.condition is not None
        assert query.then is not None
        first = self.premise = compile_without_deadlock(network, query.condition)
        inside = compile_without_deadlock(network, query.then, negated=True)
        outside = compile_without_deadlock(network, query.then)
        self.limits: dict[int, Limit] = {}
        for formula in (first, inside, outside):
            merged(self.limits, limits_of(formula))
        self._only = Only(ZoneCondition(first))
        self._within = Within(ZoneCondition(inside), ZoneCondition(outside))
        self._nodes: list[SearchNode] = []
        self.met, self.holds = False, True

    def add(self, node: SearchNode) -> None:
        """Add a symbolic state in which p may hold."""
        self._nodes.append(node)

    def judge(self, space: SymbolicSpace, progress: Progress | None = None) -> None:
        """Search the successors of the states added since the last call, then drop these states.

        Zones may be too large, never too small: a result that q follows is certain, a result that it does not may be
        wrong.
        """
        starts = [
            Start(space.record(node.record.discrete), tuple(stay.zone), ())
            for node in self._nodes
            for stay in self._only(node.record, node.zone)
        ]
        self._nodes = []
        self.met = self.met or bool(starts)
        if self.holds and starts:
            self.holds = LassoSearch(space, self._within, progress=progress).lasso(starts) is None
        for condition in (self._only.inside, self._within.inside, self._within.outside):
            condition.forget()
