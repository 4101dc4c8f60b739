"""A run of a network that shows a result, as data and as text."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Protocol

from timed_automata.network._network import Edge, Network, State


class TraceNames(Protocol):
    """Gives names to elements and values in the text of a run."""

    def element(self, name: str) -> str:
        """Return the name of an element such as ``evidence[0]`` or ``Actuator(0)``."""
        ...

    def value(self, variable: str, value: int) -> str:
        """Return the name of a value of a variable."""
        ...


class _Numbers:
    """Keeps the names and numbers of the network."""

    def element(self, name: str) -> str:
        return name

    def value(self, variable: str, value: int) -> str:
        return str(value)


@dataclass(frozen=True, slots=True)
class Change:
    """A change of a variable to another value."""

    name: str
    old: int
    new: int


def changes_between(network: Network, old: State, new: State) -> tuple[Change, ...]:
    """Return the variables that differ, in the order of declaration."""
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
        edges: edges of the participants, the sender first.
        state: the discrete state that it leads to.
        changes: changes of variables.
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
        network: the network of the run.
        steps: its transitions.
        end: the time at which the run shows its result.
        remark: the result or the end of the run, in words.
        loop: number of the step to which the run returns after the last one; None if it does not.
    """

    network: Network = field(repr=False)
    steps: tuple[TraceStep, ...]
    end: Fraction
    remark: str
    loop: int | None = None

    @property
    def lines(self) -> tuple[str, ...]:
        """The run as text: time, event, and changes of variables; the last line is the result.

        ↻ marks the steps that are repeated without end.
        """
        return self.lines_with(_Numbers())

    def lines_with(self, names: TraceNames) -> tuple[str, ...]:
        """Return the run as text with other names than those of the network."""
        return tuple(self._lines(names))

    def __str__(self) -> str:
        return "\n".join(self.lines)

    def _lines(self, names: TraceNames) -> Iterator[str]:
        times = [_ms(step.at) for step in self.steps]
        width = max(map(len, [*times, _ms(self.end)]))
        whats = [self._what(step, names) for step in self.steps]
        column = min(72, max(map(len, whats), default=0))
        for number, (time, what, step) in enumerate(zip(times, whats, self.steps, strict=True)):
            mark = "" if self.loop is None else "↻ " if number >= self.loop else "  "
            changes = ", ".join(
                f"{names.element(name)} {names.value(name, old)} → {names.value(name, new)}"
                for name, old, new in ((each.name, each.old, each.new) for each in step.changes)
            )
            yield f"{time:>{width}} ms  {mark}{what:<{column}}  {changes}".rstrip()
        yield f"{_ms(self.end):>{width}} ms  {self.remark}"

    def _what(self, step: TraceStep, names: TraceNames) -> str:
        moves = []
        for edge in step.edges:
            process = self.network.processes[edge.process]
            source, target = (process.locations[at].name for at in (edge.source, edge.target))
            chosen = ", ".join(f"{name} = {value}" for name, value in edge.selected.items())
            where = f"stays in {source}" if source == target else f"{source} → {target}"
            moves.append(f"{names.element(process.name)} {where}" + (f" ({chosen})" if chosen else ""))
        if step.channel is None:
            return moves[0]
        return f"{names.element(step.channel)}: " + "; ".join(moves)


def _ms(time: Fraction) -> str:
    if time.denominator == 1:
        return str(time.numerator)
    return f"{float(time):.4f}".rstrip("0").rstrip(".")
