"""A network of timed automata, ready to be explored, executed or monitored: numbers and compiled code."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, MutableSequence, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

from timed_automata.compiler import Condition, Effects, GeneratedCode, Quantity, Scope, Type
from timed_automata.document import Document, DrawnEdge, DrawnLocation, Span, did_you_mean
from timed_automata.errors import UsageError

Given = int | bool | Sequence["Given"]
"""A constant that is given from outside: a number, or a list (of lists) for an array."""
Update = Callable[[MutableSequence[int], list[tuple[int, int]]], None]


class State(NamedTuple):
    """The discrete part of a state: a location of each process, and all values side by side."""

    locations: tuple[int, ...]
    values: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Variable:
    """Integers or booleans (0 and 1) from ``offset`` of the values on; row-major for an array."""

    name: str
    type: Type
    offset: int


@dataclass(frozen=True, slots=True)
class Channel:
    """One channel; each element of an array of channels is one."""

    name: str
    broadcast: bool
    urgent: bool


@dataclass(frozen=True, slots=True, eq=False)
class Location:
    """A location of a process; its invariant holds upper bounds of clocks only."""

    name: str
    index: int
    urgent: bool
    committed: bool
    invariant: Condition
    effects: Effects = field(repr=False)
    drawn: DrawnLocation = field(repr=False)


@dataclass(frozen=True, slots=True, eq=False)
class Edge:
    """An edge of a process, with the values of its ``select`` put in: one of these per combination.

    Attributes:
        process, index: it is ``network.processes[process].edges[index]``.
        source, target: numbers of locations.
        direction: ``!`` sends, ``?`` receives, empty without synchronisation.
        channel: its number, or a function of the values; None without synchronisation.
        channels: all that it can be.
        update: changes values (a list or an array) in place and appends ``(clock, value)`` for each clock that it sets.
        resets: clocks that the update sets in every state.
        selected: values of the names of ``select``.
        asks: the variables and clocks that guard and channel read.
        effects: what guard, channel and update read and write.
    """

    process: int
    index: int
    source: int
    target: int
    guard: Condition
    direction: Literal["", "!", "?"]
    channel: Quantity | None
    channels: range
    update: Update | None
    resets: frozenset[int]
    selected: Mapping[str, int]
    asks: frozenset[str] = field(repr=False)
    effects: Effects = field(repr=False)
    drawn: DrawnEdge = field(repr=False)
    span: Span = field(repr=False)


@dataclass(frozen=True, slots=True, eq=False)
class Process:
    """An instance of a template; ``scope`` holds its parameters and local declarations."""

    name: str
    template: str
    index: int
    initial: int
    locations: tuple[Location, ...]
    edges: tuple[Edge, ...]
    scope: Scope = field(repr=False)


def effects_of(processes: Iterable[Process]) -> Effects:
    """What these processes touch, all together."""
    total = Effects()
    for process in processes:
        for location in process.locations:
            total.add(location.effects)
        for edge in process.edges:
            total.add(edge.effects)
    return total


@dataclass(frozen=True, slots=True, eq=False)
class Network:
    """All processes of the ``system`` line over shared variables, clocks and channels.

    Attributes:
        document: the file that it was made of.
        clocks: names; number 0 is the reference clock of zones and always zero.
        offsets: of the values by name, in order: ``ee``, ``evidence[0]``, ``Gripper.i``.
        constants: the global ones with their values.
        replaced: initialisers in the file for which constants were given, and what was put in.
        derived: what was worked out of it once, for all who work with it.
        scope, code: global names and the generated code, for compiling more (queries).
    """

    document: Document = field(repr=False)
    processes: tuple[Process, ...]
    variables: tuple[Variable, ...]
    clocks: tuple[str, ...]
    channels: tuple[Channel, ...]
    initial: State
    offsets: Mapping[str, int] = field(repr=False)
    constants: Mapping[str, Given] = field(repr=False)
    replaced: tuple[tuple[Span, str], ...] = field(repr=False)
    scope: Scope = field(repr=False)
    code: GeneratedCode = field(repr=False)
    derived: dict[object, Any] = field(default_factory=dict, init=False, repr=False)

    def offset(self, name: str) -> int:
        """Where ``evidence[1]`` or ``Gripper.i`` stands among the values.

        Raises:
            UsageError: no variable of that name.
        """
        if name not in self.offsets:
            todo = did_you_mean(name, self.offsets)
            raise UsageError(f"The network has no variable '{name}'.", todo=todo)
        return self.offsets[name]

    def variable(self, offset: int) -> Variable:
        """The variable that a value belongs to."""
        return next(v for v in reversed(self.variables) if v.offset <= offset)

    def process(self, name: str) -> Process:
        """A process by its name.

        Raises:
            UsageError: there is none.
        """
        for process in self.processes:
            if process.name == name:
                return process
        todo = did_you_mean(name, (process.name for process in self.processes))
        raise UsageError(f"The network has no process '{name}'.", todo=todo)
