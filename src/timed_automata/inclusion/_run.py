"""The run of two networks to the point where they differ."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction

from timed_automata.compiler import Bound
from timed_automata.explore.search import Timing
from timed_automata.explore.zones import Zone
from timed_automata.inclusion._macro_steps import MacroStep
from timed_automata.inclusion._zones import CommonZones
from timed_automata.network import State


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
