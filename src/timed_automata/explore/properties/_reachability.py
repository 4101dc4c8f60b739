"""The targets of one search: states that answer A[] and E<>, and states in which time cannot pass."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from timed_automata.explore.properties._verdict import Verdict
from timed_automata.explore.search import Search
from timed_automata.explore.search._concrete import Ending, NoRunError, concrete
from timed_automata.explore.search._conditions import ZoneCondition
from timed_automata.explore.search._deadlock import MOST_DOUBTS, Deadlocks
from timed_automata.explore.search._stages import SearchNode
from timed_automata.explore.states import StateRecord
from timed_automata.explore.zones import Limit, Zone
from timed_automata.explore.zones._limits import limits_of
from timed_automata.network import Network
from timed_automata.queries import Query, compile_formula, mentions_deadlock


@dataclass(slots=True, eq=False)
class Reachability:
    """A target that a search looks for, and its answer.

    Attributes:
        query: the text of the query.
        part: returns the part of a zone that is a target.
        remark: description of the end of a run to the target.
        invariance: whether the target must not be reachable.
        about_deadlock: whether the target is about deadlocks.
        limits: limits of clocks that the zones must keep.
        verdict: the answer; None if there is none yet.
        doubts: number of deadlocks that were found in widened zones and proved unreal.
    """

    query: str
    part: Ending
    remark: str
    invariance: bool
    about_deadlock: bool
    limits: Mapping[int, Limit] = field(default_factory=dict)
    verdict: Verdict | None = None
    doubts: int = 0

    def decide(self, search: Search, node: SearchNode | None) -> None:
        """Set the verdict: the target was found at ``node``, or is not reachable (None)."""
        trace = None if node is None else concrete(search.space, node.legs, self.part, self.remark)
        self.verdict = Verdict(self.query, (node is None) == self.invariance, search.states, trace)


def reachability(network: Network, query: Query) -> Reachability:
    """Return the target of a query A[] or E<>: p for ``E<> p``, the negation of p for ``A[] p``."""
    assert query.condition is not None
    invariance = query.kind == "A[]"
    wanted = compile_formula(network, query.condition, negated=invariance)
    remark = f"{query.condition.span.snippet}: {'does not hold' if invariance else 'holds'}"
    part, limits = ZoneCondition(wanted).part, limits_of(wanted)
    return Reachability(str(query), part, remark, invariance, mentions_deadlock(wanted), limits)


def timelock() -> Reachability:
    """Return the target of a deadlock in which time cannot go on either; it must not be reachable."""
    deadlocks = Deadlocks()

    def part(record: StateRecord, zone: Zone) -> Zone | None:
        return (
            None if record.discrete.endless or deadlocks.ruled_out(record) else deadlocks.part(record, zone)
        )

    remark = "no transition is possible, and time cannot go on"
    return Reachability("", part, remark, invariance=True, about_deadlock=True)


def answer(search: Search, asked: list[Reachability], *, trusted: bool) -> None:
    """Search until all targets have a verdict.

    Zones widened by ExtraLU+ contain valuations that are equivalent only in their transitions: a deadlock found in one
    counts only if the exact zone of the run has it too. Doubtful cases are left to a search with ExtraM+, which
    separates deadlocked valuations from others (``trusted``).
    """
    open_ = list(asked)
    for node in search.nodes():
        answered = False
        for one in open_:
            if one.doubts <= MOST_DOUBTS and one.part(node.record, node.zone) is not None:
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
