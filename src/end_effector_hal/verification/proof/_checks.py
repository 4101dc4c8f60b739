"""What no query says and every model must satisfy: all of it can happen, time goes on, channels have both ends."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from time import perf_counter

from timed_automata import Network, Trace, make_network
from timed_automata.explore import CoverageReport, Explorer, Overview, overview

from ._finding import Finding


@dataclass(frozen=True, slots=True)
class Check:
    """One of them; ``states`` and ``seconds`` are zero if the one exploration of all requirements decided it."""

    id: str
    sentence: str
    remark: str = ""
    trace: Trace | None = field(default=None, repr=False)
    states: int = 0
    seconds: float = 0.0

    def finding(self, states: int, seconds: float) -> Finding:
        """As a finding; the arguments are those of the one exploration."""
        states, seconds = self.states or states, self.seconds or seconds
        return Finding(self.id, self.sentence, "", not self.remark, states, seconds, self.remark, self.trace)


def checks(network: Network, explorer: Explorer, found: Overview) -> tuple[Check, ...]:
    """Of one network, after the exploration ``found``.

    Raises:
        RunTimeError: a value leaves its range.
    """
    missing = found.coverage
    return (
        Check("locations", "Every location can be reached.", _listed(missing.locations)),
        Check("edges", "Every edge can fire.", _listed(missing.edges)),
        Check("channels", "Every channel has both ends.", _listed(found.open_channels)),
        _time(explorer, found),
    )


def without_unused(network: Network, found: Overview) -> Overview:
    """Take what happens with the constants of the file itself for switched off by those that were given.

    A tool with one step has no step before another one: the edges for that are not dead, they are not needed.
    """
    missing = found.coverage
    if not network.replaced or not (missing.edges or missing.locations):
        return found
    there = overview(make_network(network.document), []).coverage
    edges = tuple(edge for edge in missing.edges if edge in there.edges)
    locations = tuple(location for location in missing.locations if location in there.locations)
    unused = tuple(edge for edge in missing.edges if edge not in there.edges)
    return replace(found, coverage=CoverageReport(locations, edges, (*missing.disabled, *unused)))


def _listed(faults: tuple[str, ...]) -> str:
    return "; ".join(faults)


def _time(explorer: Explorer, found: Overview) -> Check:
    id_, sentence = "time", "Time can always pass: no timelock, and no endless run in finite time."
    if not (found.stopped or found.zeno):
        return Check(id_, sentence)
    begun, verdict = perf_counter(), None
    if found.stopped:
        verdict = explorer.timelock()
    if (verdict is None or verdict.holds) and found.zeno:
        verdict = explorer.zeno()
    assert verdict is not None
    remark = "" if verdict.trace is None else verdict.trace.remark
    return Check(id_, sentence, remark, verdict.trace, verdict.states, perf_counter() - begun)
