"""What every model must satisfy, whatever its queries: all of it can happen, and time can always pass."""

from __future__ import annotations

from dataclasses import dataclass

from timed_automata.explore.properties._coverage_report import CoverageReport, coverage_report, open_channels
from timed_automata.explore.properties._divergence import NO_TIME, taken, zeno_run
from timed_automata.explore.search import Deadlocks, Search, SearchNode, concrete
from timed_automata.network import Trace


@dataclass(frozen=True, slots=True)
class SanityReport:
    """The findings; empty and None are good.

    Attributes:
        states: symbolic states that were stored.
        coverage: locations that are never entered, edges that are never taken.
        open_channels: channels that are only sent on or only received on, in words.
        deadlock: a run to a state without any transition, now or later.
        timelock: a run to a deadlock in which time cannot go on either.
        zeno: a run to, and once round, a cycle on which no time needs to pass.
    """

    states: int
    coverage: CoverageReport
    open_channels: tuple[str, ...]
    deadlock: Trace | None
    timelock: Trace | None
    zeno: Trace | None

    @property
    def diverges(self) -> bool:
        """Whether from every state time can pass without end, and does so in every infinite run."""
        return self.timelock is None and self.zeno is None

    @property
    def complete(self) -> bool:
        """Whether every edge can fire, every location can be reached, every channel has both ends."""
        return not (self.coverage.locations or self.coverage.edges or self.open_channels)

    @property
    def ok(self) -> bool:
        """Whether nothing was found."""
        return self.complete and self.diverges and self.deadlock is None


def sanity_of(search: Search) -> SanityReport:
    """Explore everything; ``search`` must have symmetric limits, as deadlocks are looked for.

    Raises:
        OutOfRangeError: a value leaves its range on the way.
    """
    deadlocks, deadlock, timelock = Deadlocks(), None, None
    for node in search.nodes():
        if (deadlock is None or timelock is None) and deadlocks.of(node.record, node.zone):
            deadlock = deadlock or node
            discrete = node.record.discrete
            if not discrete.delays or discrete.invariant:
                timelock = timelock or node

    def run(node: SearchNode | None, remark: str) -> Trace | None:
        return None if node is None else concrete(search.space, node.legs, deadlocks.part, remark)

    arcs = list(taken(search.space.records))
    return SanityReport(
        states=search.states,
        coverage=coverage_report(search.space, arcs),
        open_channels=tuple(open_channels(search.space.discrete.network)),
        deadlock=run(deadlock, "no transition is possible, now or later"),
        timelock=run(timelock, NO_TIME),
        zeno=zeno_run(search, arcs),
    )
