"""Queries of the kinds A[] and E<>, several of them answered by one search."""

from __future__ import annotations

from timed_automata.explore.properties._verdict import Verdict
from timed_automata.explore.search import MOST_DOUBTS, NoRunError, Search, SearchNode, ZoneCondition, concrete
from timed_automata.network import Network
from timed_automata.queries import Query, compile_formula, mentions_deadlock


class Reachability:
    """A query of the kind A[] or E<> that waits for its answer.

    Attributes:
        query: as read.
        wanted: what is looked for: p of ``E<> p``, the contrary of p of ``A[] p``.
        about_deadlock: whether that asks for deadlocks.
        verdict: None: not answered yet.
        doubts: deadlocks that were found in widened zones and are none.
    """

    def __init__(self, network: Network, query: Query) -> None:
        assert query.condition is not None
        self.query, self.invariance = query, query.kind == "A[]"
        self.wanted = compile_formula(network, query.condition, negated=self.invariance)
        self.cases = ZoneCondition(self.wanted)
        self.about_deadlock = mentions_deadlock(self.wanted)
        self.remark = f"{query.condition.span.snippet}: {'does not hold' if self.invariance else 'holds'}"
        self.verdict: Verdict | None = None
        self.doubts = 0

    def decide(self, search: Search, node: SearchNode | None) -> None:
        """Found, or not found anywhere."""
        trace = None if node is None else concrete(search.space, node.legs, self.cases.part, self.remark)
        self.verdict = Verdict(str(self.query), (node is None) == self.invariance, search.states, trace)


def answer(search: Search, asked: list[Reachability], *, trusted: bool) -> None:
    """Search until all are answered.

    Zones widened by ExtraLU+ hold valuations that only behave like others as far as transitions go: a deadlock that
    is found in one counts if the exact zone of the run has it too. What is left in doubt waits for ExtraM+, which
    tells deadlocked valuations from others (``trusted``).
    """
    open_ = list(asked)
    for node in search.nodes():
        answered = False
        for one in open_:
            if one.doubts <= MOST_DOUBTS and one.cases.part(node.record, node.zone) is not None:
                try:
                    one.decide(search, node)
                    answered = True
                except NoRunError:
                    if trusted or not one.about_deadlock:
                        raise
                    one.doubts += 1
        if answered:
            open_ = [one for one in open_ if one.verdict is None]
            if not open_:
                return
    for one in open_:
        if trusted or not one.doubts:
            one.decide(search, None)
        one.doubts = 0
