"""Limits that a query needs in some locations only.

``A[] (P.L && …) imply x <= c`` asks for x while P is in L. Elsewhere its value matters only if P can come to L without
setting x on the way: the same propagation, along the edges of one process, that gives the limits of guards.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from timed_automata.explore.zones._limits import ByClock, Limit, Limits, merged
from timed_automata.network import Network, Process


class QueryLimits(NamedTuple):
    """Limits that a query asks for; ``at``: process and location, None: everywhere."""

    limits: ByClock
    at: tuple[int, int] | None = None


class LocatedLimits(Limits):
    """The limits of a network and of queries that each ask in one location, or everywhere."""

    def __init__(self, network: Network, asked: Iterable[QueryLimits], *, symmetric: bool = False) -> None:
        everywhere: dict[int, Limit] = {}
        located: dict[int, list[tuple[int, ByClock]]] = {}
        for limits, at in asked:
            if at is None:
                merged(everywhere, limits)
            else:
                located.setdefault(at[0], []).append((at[1], limits))
        super().__init__(network, everywhere, symmetric=symmetric)
        for process, added in located.items():
            _propagate(network.processes[process], self._processes[process], added)


def _propagate(process: Process, limits: list[dict[int, Limit]], added: list[tuple[int, ByClock]]) -> None:
    """Against the edges, until a clock is set."""
    for location, more in added:
        merged(limits[location], more)
    changed = True
    while changed:
        changed = False
        for edge in process.edges:
            after = limits[edge.target].items()
            if not edge.guard.never:
                passed = {clock: limit for clock, limit in after if clock not in edge.resets}
                changed = merged(limits[edge.source], passed) or changed


def tested_clocks(network: Network) -> set[int]:
    """The clocks that the network itself tests; the others are there for queries."""
    conditions = [location.invariant for process in network.processes for location in process.locations]
    conditions += [edge.guard for process in network.processes for edge in process.edges]
    return {clock for condition in conditions for bound in condition.clocks for clock in bound.clocks}
