"""Zones over the clocks of both networks of a comparison, and the run to the point where the networks differ."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from timed_automata.compiler import Bound
from timed_automata.explore.search import Timing
from timed_automata.explore.zones import (
    AT_MOST_ZERO,
    INFINITY,
    Limit,
    Limits,
    Zone,
    as_constraints,
    constrained,
    constraints_of,
    extrapolated,
    subtract,
    up,
    widening,
)
from timed_automata.inclusion._interface import Side
from timed_automata.inclusion._macro_steps import MacroStep
from timed_automata.network import State


class CommonZones:
    """The zones of two sides: the clocks x_1, x_2, … are those tested in the first, then those tested in the second."""

    def __init__(self, both: Sequence[Side]) -> None:
        self._both = both
        self.n = 1 + sum(len(side.index) for side in both)
        self._places = {place: place for place in range(1, self.n)}
        # what a guard does not allow is asked for, too: the same limit for lower and upper bounds
        self._limits = [Limits(side.network, symmetric=True) for side in both]

    @property
    def start(self) -> Zone:
        """The zone in which all clocks are zero."""
        return (AT_MOST_ZERO,) * (self.n * self.n)

    def within(self, zone: Zone, bounds: Iterable[Bound]) -> Zone | None:
        """Return the part of a zone that satisfies all bounds, or None if it is empty."""
        return constrained(zone, self.n, as_constraints(bounds, self._places))

    def without(self, zones: Sequence[Zone], bounds: Iterable[Bound]) -> list[Zone]:
        """Return the parts of zones that do not satisfy all bounds."""
        constraints = as_constraints(bounds, self._places)
        return [piece for zone in zones for piece in subtract(zone, constraints, self.n)]

    def later(self, zone: Zone) -> Zone:
        """Return the zone after any delay."""
        return up(zone, self.n)

    def set(self, zone: Zone, resets: Mapping[int, int]) -> Zone:
        """Return the zone with clocks set to values."""
        n, found = self.n, list(zone)
        for place, value in resets.items():
            for other in range(n):
                lower, upper = found[other], found[other * n]
                found[place * n + other] = lower + 2 * value
                found[other * n + place] = upper - 2 * value if upper != INFINITY else INFINITY
            found[place * n + place] = AT_MOST_ZERO
        return tuple(found)

    def widened(self, zone: Zone, states: Sequence[State]) -> Zone:
        """Return a zone extended by equivalent valuations: beyond the largest constant a clock's value does not
        matter.
        """
        limits = [Limit()] * (self.n - 1)
        for side, known, state in zip(self._both, self._limits, states, strict=True):
            at = known.at(state.locations)
            for clock, place in side.index.items():
                limits[place - 1] = at.get(clock, Limit())
        return extrapolated(list(zone), self.n, widening(limits))

    def constraints(self, zone: Zone) -> list[tuple[int, int, int]]:
        """Return the bounds of a zone that are a restriction."""
        return constraints_of(zone, self.n)


@dataclass(frozen=True, slots=True, eq=False)
class ComparedNode:
    """A reached pair of states and the step that led to it.

    Attributes:
        parent: the pair where the last step began; None at the start.
        ours, theirs: the states of the implementation and of the specification.
        zone: values of the clocks, after any delay.
        what: the last step, in words; empty if nothing of it is observed.
        steps: macro-steps of the implementation, of the specification, or of both.
    """

    parent: ComparedNode | None
    ours: State
    theirs: State
    zone: Zone
    what: str
    steps: Sequence[MacroStep]


@dataclass(frozen=True, slots=True)
class ComparedStep:
    """An observation that both networks share.

    Attributes:
        at: time in the model's unit.
        what: inputs, outputs and changes, in words.
    """

    at: Fraction
    what: str

    def __str__(self) -> str:
        at = str(self.at) if self.at.denominator == 1 else f"{float(self.at):.4f}".rstrip("0").rstrip(".")
        return f"{at:>8}  {self.what}"


def run_to(
    node: ComparedNode,
    zone: Zone,
    zones: CommonZones,
    invariant: Callable[[State, State], tuple[Bound, ...]],
) -> tuple[tuple[ComparedStep, ...], Fraction]:
    """Return the earliest run that ends in a zone of a node, and the time of its end."""
    nodes: list[ComparedNode] = []
    at: ComparedNode | None = node
    while at is not None:
        nodes.append(at)
        at = at.parent
    timing, instants = Timing(), []
    for each in reversed(nodes):
        for step in each.steps:
            timing.require(step.bounds)
        for step in each.steps:
            for place, value in step.resets.items():
                timing.set(place, value)
        instants.append(timing.now)
        timing.advance(delays=True)
        timing.require(invariant(each.ours, each.theirs))
    for i, j, bound in zones.constraints(zone):
        timing.require_difference(i, j, bound)
    times = timing.solve()
    steps = [
        ComparedStep(times[instant], each.what)
        for instant, each in zip(instants, reversed(nodes), strict=True)
        if each.what
    ]
    return tuple(steps), times[-1]
