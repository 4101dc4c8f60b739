"""``p --> q`` after an exploration of everything: only what follows the states of p is looked at."""

from __future__ import annotations

from timed_automata import Network, refused
from timed_automata import _ast as ast
from timed_automata.explore._cases import Cases
from timed_automata.explore._delay import Only, Within
from timed_automata.explore._discrete import DiscreteSpace
from timed_automata.explore._formula import Formula, compile_formula, limits_of, mentions_deadlock
from timed_automata.explore._limits import Limit, Limits, merged
from timed_automata.explore._liveness import Start, Staying
from timed_automata.explore._query import Query
from timed_automata.explore._reach import Node
from timed_automata.explore._symbolic import SymbolicSpace


class Response:
    """One such query.

    Attributes:
        limits: that the zones must keep.
        premise: p.
    """

    def __init__(self, network: Network, query: Query) -> None:
        assert query.condition is not None
        assert query.then is not None
        first = self.premise = _compiled(network, query.condition)
        inside, outside = _compiled(network, query.then, negated=True), _compiled(network, query.then)
        self.limits: dict[int, Limit] = {}
        for formula in (first, inside, outside):
            merged(self.limits, limits_of(formula))
        self._first, self._within = Cases(first), Within(Cases(inside), Cases(outside))
        self._nodes: list[Node] = []

    def see(self, node: Node) -> None:
        """Note a symbolic state in which p may hold."""
        self._nodes.append(node)

    @property
    def met(self) -> bool:
        """Whether p held anywhere."""
        only = Only(self._first)
        return any(only(node.place, node.zone) for node in self._nodes)

    def holds(self, discrete: DiscreteSpace, limits: Limits) -> bool:
        """Whether q follows. Zones are too large here, never too small: False may be wrong, True is not."""
        space, only = SymbolicSpace(discrete, limits, delays=False), Only(self._first)
        starts = (
            Start(space.place(node.place.discrete), tuple(stay.zone), ())
            for node in self._nodes
            for stay in only(node.place, node.zone)
        )
        return Staying(space, self._within).lasso(starts) is None


def _compiled(network: Network, node: ast.Expression, *, negated: bool = False) -> Formula:
    formula = compile_formula(network, node, negated=negated)
    if mentions_deadlock(formula):
        raise refused(node.span, f"'{node.span.snippet}', 'deadlock' outside of A[] and E<>")
    return formula
