"""A run as stretches: a discrete state each, and what the clocks show while it lasts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from timed_automata.network import Semantics, State, Trace


@dataclass(frozen=True, slots=True)
class Stretch:
    """From one transition of a run to the next.

    Attributes:
        state: the discrete state.
        begun, ended: absolute times.
        set_at: of each clock by its number: when it would have been zero.
    """

    state: State
    begun: Fraction
    ended: Fraction
    set_at: tuple[Fraction, ...]

    @property
    def entry(self) -> Instant:
        """Just after the transition that leads here."""
        return Instant(self.state, self.begun, self.set_at)

    @property
    def end(self) -> Instant:
        """Just before the next transition, or where the run ends."""
        return Instant(self.state, self.ended, self.set_at)


@dataclass(frozen=True, slots=True)
class Instant:
    """A state of a run: the discrete one, and the time."""

    state: State
    at: Fraction
    set_at: tuple[Fraction, ...]

    def clock(self, number: int) -> Fraction:
        """What a clock shows."""
        return self.at - self.set_at[number] if number else Fraction(0)


def stretches_of(trace: Trace) -> list[Stretch]:
    """The run, one stretch more than it has steps.

    Raises:
        RangeError: the last step of the run leaves a range.
    """
    semantics, state = Semantics(trace.network), trace.network.initial
    set_at = [Fraction(0)] * len(trace.network.clocks)
    found: list[Stretch] = []
    begun = Fraction(0)
    for step in trace.steps:
        found.append(Stretch(state, begun, step.at, tuple(set_at)))
        for clock, value in semantics.fire(state, step.edges).resets:
            set_at[clock] = step.at - value
        state, begun = step.state, step.at
    found.append(Stretch(state, begun, trace.end, tuple(set_at)))
    return found


def told_time(ms: Fraction | int) -> str:
    """Whole seconds and their parts from one second on, else milliseconds."""
    exact = Fraction(ms)
    number, unit = (exact / 1000, "s") if abs(exact) >= 1000 else (exact, "ms")
    return f"{float(number):.6f}".rstrip("0").rstrip(".") + f" {unit}"


def listed(words: Sequence[str], most: int, last: str = "and") -> str:
    """``a, b and c``; of more than ``most`` it says how many are left out."""
    shown = [*words[:most], f"{len(words) - most} more"] if len(words) > most else list(words)
    return "".join(shown) if len(shown) < 2 else f"{', '.join(shown[:-1])} {last} {shown[-1]}"
