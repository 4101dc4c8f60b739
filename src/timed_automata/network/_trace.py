"""A run of a network that shows something: what happens when, in numbers and in words."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction

from timed_automata.network._network import Edge, Network, State


@dataclass(frozen=True, slots=True)
class Change:
    """A variable that got another value."""

    name: str
    old: int
    new: int


def changes_between(network: Network, old: State, new: State) -> tuple[Change, ...]:
    """The variables that differ, in the order in which they are declared."""
    return tuple(
        Change(name, old.values[at], new.values[at])
        for name, at in network.offsets.items()
        if old.values[at] != new.values[at]
    )


@dataclass(frozen=True, slots=True)
class TraceStep:
    """A discrete transition of a concrete run.

    Attributes:
        at: absolute time in the model's unit (ms).
        channel: name of the channel; None without synchronisation.
        edges: the participants, the sender first.
        state: the discrete state that it leads to.
        changes: of variables.
    """

    at: Fraction
    channel: str | None
    edges: tuple[Edge, ...]
    state: State
    changes: tuple[Change, ...]


@dataclass(frozen=True, slots=True)
class Trace:
    """A concrete run from the initial state.

    Attributes:
        network: of which this is a run.
        steps: its transitions.
        end: the time at which it shows what it shows.
        remark: how it ends, in words.
        loop: number of the step to which the run returns after the last one; None if it does not.
    """

    network: Network = field(repr=False)
    steps: tuple[TraceStep, ...]
    end: Fraction
    remark: str
    loop: int | None = None

    @property
    def lines(self) -> tuple[str, ...]:
        """The run as text: time, what happens, which variables change; the last line says what it shows.

        ↻ marks the steps that are repeated without end.
        """
        return tuple(self._lines())

    def __str__(self) -> str:
        return "\n".join(self.lines)

    def _lines(self) -> Iterator[str]:
        times = [_ms(step.at) for step in self.steps]
        width = max(map(len, [*times, _ms(self.end)]))
        whats = [self._what(step) for step in self.steps]
        column = min(72, max(map(len, whats), default=0))
        for number, (time, what, step) in enumerate(zip(times, whats, self.steps, strict=True)):
            mark = "" if self.loop is None else "↻ " if number >= self.loop else "  "
            changes = ", ".join(f"{change.name} {change.old} → {change.new}" for change in step.changes)
            yield f"{time:>{width}} ms  {mark}{what:<{column}}  {changes}".rstrip()
        yield f"{_ms(self.end):>{width}} ms  {self.remark}"

    def _what(self, step: TraceStep) -> str:
        moves = []
        for edge in step.edges:
            process = self.network.processes[edge.process]
            source, target = (process.locations[at].name for at in (edge.source, edge.target))
            chosen = ", ".join(f"{name} = {value}" for name, value in edge.selected.items())
            where = f"stays in {source}" if source == target else f"{source} → {target}"
            moves.append(f"{process.name} {where}" + (f" ({chosen})" if chosen else ""))
        if step.channel is None:
            return moves[0]
        return f"{step.channel}: " + "; ".join(moves)


def _ms(time: Fraction) -> str:
    if time.denominator == 1:
        return str(time.numerator)
    return f"{float(time):.4f}".rstrip("0").rstrip(".")
