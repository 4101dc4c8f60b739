"""Largest constants that clocks are compared with, by location: beyond these the value of a clock does not matter.

Lower and upper bounds are separate, computed backwards along the edges of every process until a clock is set
(Behrmann, Bouyer, Larsen, Pelánek, *Lower and Upper Bounds in Zone-Based Abstractions of Timed Automata*, 2006). A
clock without any limit in a location is not active there: its value is not read before it is set again.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

from timed_automata.compiler import Bound, ClockConstraint
from timed_automata.document import fault
from timed_automata.explore.zones._zone import LARGEST
from timed_automata.network import Network, Process
from timed_automata.queries import All, Comparison, Formula, Some

NEVER = -1  # not compared in this direction


class Limit(NamedTuple):
    """Largest constant in ``x > c`` and ``x >= c`` (lower), and in ``x < c`` and ``x <= c`` (upper)."""

    lower: int = NEVER
    upper: int = NEVER


ByClock = Mapping[int, Limit]


def merged(left: dict[int, Limit], right: ByClock) -> bool:
    """Widen ``left`` in place; return whether it changed."""
    changed = False
    for clock, limit in right.items():
        old = left.get(clock)
        if old is None:
            left[clock] = limit
            changed = True
            continue
        new = Limit(max(old.lower, limit.lower), max(old.upper, limit.upper))
        if new != old:
            left[clock] = new
            changed = True
    return changed


def of_bounds(bounds: Iterable[Bound]) -> dict[int, Limit]:
    """Return the limits that clock constraints need."""
    limits: dict[int, Limit] = {}
    for clock, op, value in bounds:
        if value >= 0:
            lower = value if op in (">", ">=", "==") else NEVER
            upper = value if op in ("<", "<=", "==") else NEVER
            merged(limits, {clock: Limit(lower, upper)})
        elif clock not in limits:
            limits[clock] = Limit(NEVER, 0)  # never true, but the clock must be there to be compared
    return limits


def limits_of(formula: Formula) -> dict[int, Limit]:
    """Return the clock limits that a formula needs."""
    limits: dict[int, Limit] = {}
    if isinstance(formula, Comparison):
        constraint = formula.constraint
        merged(limits, of_bounds(Bound(clock, constraint.op, constraint.high) for clock in constraint.clocks))
    elif isinstance(formula, All | Some):
        for part in formula.parts:
            merged(limits, limits_of(part))
    return limits


def _of_constraints(constraints: Iterable[ClockConstraint], *, negated: bool = False) -> dict[int, Limit]:
    """Return the limits that constraints need; ``negated``: the contrary of each is asked for as well."""
    for constraint in constraints:
        if constraint.high >= LARGEST:
            what = f"'{constraint.span.snippet}' compares a clock with up to {constraint.high}."
            raise fault(constraint.span, what, f"The largest that is supported is {LARGEST - 1}.")
    return of_bounds(
        Bound(clock, "==" if negated else constraint.op, constraint.high)
        for constraint in constraints
        for clock in constraint.clocks
    )


def _constraints(network: Network) -> Iterator[ClockConstraint]:
    """Yield all clock constraints of the network."""
    for process in network.processes:
        for location in process.locations:
            yield from location.invariant.clocks
        for edge in process.edges:
            if not edge.guard.never:
                yield from edge.guard.clocks


def largest(network: Network) -> int:
    """Return the largest constant that the network compares a clock with."""
    return max((constraint.high for constraint in _constraints(network)), default=0)


def tested_clocks(network: Network) -> set[int]:
    """Return the clocks that the network itself tests; the others serve queries."""
    return {clock for constraint in _constraints(network) for clock in constraint.clocks}


def _of_process(network: Network, process: Process, asked: Iterable[QueryLimits]) -> list[dict[int, Limit]]:
    """Return the limits per location of a process, propagated backwards along the edges until a clock is set."""
    limits = [_of_constraints(location.invariant.clocks) for location in process.locations]
    for query in asked:
        if query.at is not None and query.at[0] == process.index:
            merged(limits[query.at[1]], query.limits)
    edges = [edge for edge in process.edges if not edge.guard.never]
    for edge in edges:
        here = _of_constraints(edge.guard.clocks, negated=network.broadcast_by_clock(edge))
        merged(limits[edge.source], here)
    changed = True
    while changed:
        changed = False
        for edge in edges:
            after = limits[edge.target]
            passed = {clock: limit for clock, limit in after.items() if clock not in edge.resets}
            changed = merged(limits[edge.source], passed) or changed
    return limits


class QueryLimits(NamedTuple):
    """Limits that a query needs; ``at``: process and location where it needs them, None: everywhere.

    ``A[] (P.L && …) imply x <= c`` needs x while P is in L. Elsewhere the value matters only if P can reach L without
    setting x on the way, as with the limits of guards.
    """

    limits: ByClock
    at: tuple[int, int] | None = None


class Limits:
    """The limits of a network and of queries.

    ``symmetric``: use one limit for both directions, which deadlock and liveness need (ExtraM+ instead of ExtraLU+).
    """

    def __init__(
        self, network: Network, asked: Iterable[QueryLimits] = (), *, symmetric: bool = False
    ) -> None:
        self._network, self._asked, self._symmetric = network, tuple(asked), symmetric
        self._everywhere: dict[int, Limit] = {}
        for query in self._asked:
            if query.at is None:
                merged(self._everywhere, query.limits)
        self._processes = [_of_process(network, process, self._asked) for process in network.processes]
        self._places = [
            (process, _numbered(limits)) for process, limits in enumerate(self._processes) if any(limits)
        ]
        self._known: dict[tuple[int, ...], dict[int, Limit]] = {}
        self._found: dict[object, dict[int, Limit]] = {}

    def and_also(self, extra: ByClock) -> Limits:
        """Return these limits extended by further ones."""
        return Limits(self._network, (*self._asked, QueryLimits(extra)), symmetric=self._symmetric)

    def at(self, locations: tuple[int, ...]) -> dict[int, Limit]:
        """Return the limits of the active clocks in the order of their numbers; equal limits are one object."""
        key = tuple([numbers[locations[process]] for process, numbers in self._places])
        known = self._known.get(key)
        if known is None:
            found = dict(self._everywhere)
            for process, _ in self._places:
                merged(found, self._processes[process][locations[process]])
            if self._symmetric:
                found = {clock: Limit(max(limit), max(limit)) for clock, limit in found.items()}
            found = dict(sorted(found.items()))
            same = tuple(found), tuple(found.values())
            known = self._known[key] = self._found.setdefault(same, found)
        return known


def _numbered(limits: list[dict[int, Limit]]) -> list[int]:
    """Return a number for every location of a process; locations with the same limits have the same number."""
    return [limits.index(here) for here in limits]
