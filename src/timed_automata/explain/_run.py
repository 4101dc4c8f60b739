"""Divides a run into stretches: one discrete state each, with the values of the clocks while it lasts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from timed_automata.network import Semantics, State, Trace


@dataclass(frozen=True, slots=True)
class Stretch:
    """The part of a run between two transitions.

    Attributes:
        state: the discrete state.
        begun, ended: absolute times.
        set_at: time at which a clock would have been zero, by its number.
    """

    state: State
    begun: Fraction
    ended: Fraction
    set_at: tuple[Fraction, ...]

    @property
    def entry(self) -> Instant:
        """The instant just after the transition that leads into this stretch."""
        return Instant(self.state, self.begun, self.set_at)

    @property
    def end(self) -> Instant:
        """The instant just before the next transition, or at the end of the run."""
        return Instant(self.state, self.ended, self.set_at)


@dataclass(frozen=True, slots=True)
class Instant:
    """An instant of a run: the discrete state, the time, and the clocks."""

    state: State
    at: Fraction
    set_at: tuple[Fraction, ...]

    def clock(self, number: int) -> Fraction:
        """Return the value of a clock."""
        return self.at - self.set_at[number] if number else Fraction(0)


def stretches_of(trace: Trace) -> list[Stretch]:
    """Return the stretches of the run, one more than it has steps.

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
    """Return a time, given in ms, as text: in seconds from one second on, else in milliseconds."""
    exact = Fraction(ms)
    number, unit = (exact / 1000, "s") if abs(exact) >= 1000 else (exact, "ms")
    return f"{float(number):.6f}".rstrip("0").rstrip(".") + f" {unit}"


def listed(words: Sequence[str], most: int, last: str = "and") -> str:
    """Return ``a, b and c``; if there are more than ``most`` words, the rest is given as a number."""
    shown = [*words[:most], f"{len(words) - most} more"] if len(words) > most else list(words)
    return "".join(shown) if len(shown) < 2 else f"{', '.join(shown[:-1])} {last} {shown[-1]}"
