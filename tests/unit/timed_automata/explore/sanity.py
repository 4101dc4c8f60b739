"""What every model must satisfy, found by a plain search: an overview is held against it."""

from __future__ import annotations

from dataclasses import dataclass

from timed_automata import Network, Trace
from timed_automata.explore import CoverageReport, Explorer
from timed_automata.explore.properties import Coverage
from timed_automata.explore.properties._coverage_report import open_channels
from timed_automata.explore.properties._zeno import taken
from timed_automata.explore.search import Search
from timed_automata.explore.states import SymbolicSpace
from timed_automata.explore.zones import Limits


@dataclass(frozen=True)
class SanityReport:
    """The findings; empty and None are good: runs to a deadlock, to one in which time cannot go on, to a Zeno cycle."""

    states: int
    coverage: CoverageReport
    open_channels: tuple[str, ...]
    deadlock: Trace | None
    timelock: Trace | None
    zeno: Trace | None

    @property
    def diverges(self) -> bool:
        return self.timelock is None and self.zeno is None

    @property
    def complete(self) -> bool:
        return not (self.coverage.locations or self.coverage.edges or self.open_channels)

    @property
    def ok(self) -> bool:
        return self.complete and self.diverges and self.deadlock is None


def sanity_check(network: Network) -> SanityReport:
    """Everything is explored, with all variables: nothing of this is shared with an overview."""
    explorer = Explorer(network)
    deadlock, timelock, zeno = explorer.check("A[] not deadlock"), explorer.timelock(), explorer.zeno()
    search = Search(SymbolicSpace(explorer.discrete, Limits(network, symmetric=True)))
    for _ in search.nodes():
        pass
    coverage = Coverage()
    coverage.add(search.space.records, taken(search.space.records))
    return SanityReport(
        states=search.states,
        coverage=coverage.report(network),
        open_channels=tuple(open_channels(network)),
        deadlock=deadlock.trace,
        timelock=timelock.trace,
        zeno=zeno.trace,
    )
