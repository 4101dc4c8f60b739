"""``p --> q`` after an exploration of everything: only what follows the states of p is looked at."""

from __future__ import annotations

from timed_automata.explore.search import LassoSearch, Only, SearchNode, Start, Within, ZoneCondition
from timed_automata.explore.states import DiscreteSpace, SymbolicSpace
from timed_automata.explore.zones import Limit, Limits, limits_of, merged
from timed_automata.network import Network
from timed_automata.queries import Query, compile_without_deadlock


class LeadsTo:
    """One such query.

    Attributes:
        limits: that the zones must keep.
        premise: p.
    """

    def __init__(self, network: Network, query: Query) -> None:
        assert query.condition is not None
        assert query.then is not None
        first = self.premise = compile_without_deadlock(network, query.condition)
        inside, outside = (
            compile_without_deadlock(network, query.then, negated=True),
            compile_without_deadlock(network, query.then),
        )
        self.limits: dict[int, Limit] = {}
        for formula in (first, inside, outside):
            merged(self.limits, limits_of(formula))
        self._first, self._within = (
            ZoneCondition(first),
            Within(ZoneCondition(inside), ZoneCondition(outside)),
        )
        self._nodes: list[SearchNode] = []

    def add(self, node: SearchNode) -> None:
        """Note a symbolic state in which p may hold."""
        self._nodes.append(node)

    @property
    def met(self) -> bool:
        """Whether p held anywhere."""
        only = Only(self._first)
        return any(only(node.record, node.zone) for node in self._nodes)

    def holds(self, discrete: DiscreteSpace, limits: Limits) -> bool:
        """Whether q follows. Zones are too large here, never too small: False may be wrong, True is not."""
        space, only = SymbolicSpace(discrete, limits, delays=False), Only(self._first)
        starts = (
            Start(space.record(node.record.discrete), tuple(stay.zone), ())
            for node in self._nodes
            for stay in only(node.record, node.zone)
        )
        return LassoSearch(space, self._within).lasso(starts) is None
