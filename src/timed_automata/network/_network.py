"""A network of timed automata for exploration, execution and monitoring: numbers and compiled code."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, MutableSequence, Sequence
from dataclasses import dataclass, field
from itertools import islice
from typing import Any, Literal, NamedTuple

from timed_automata.compiler import Condition, Effects, GeneratedCode, Quantity, Scope, Type
from timed_automata.document import Document, DrawnEdge, DrawnLocation, Span, did_you_mean, refused
from timed_automata.errors import UsageError

Given = int | bool | Sequence["Given"]
"""A constant that is given from outside: a number, or a list (of lists) for an array."""
Update = Callable[[MutableSequence[int], list[tuple[int, int]]], None]


class State(NamedTuple):
    """The discrete part of a state: one location per process, and all values in one tuple."""

    locations: tuple[int, ...]
    values: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Variable:
    """A variable: integers or booleans (0 and 1) that begin at ``offset`` of the values, row-major for an array, and
    for a structure field by field.
    """

    name: str
    type: Type
    offset: int


@dataclass(frozen=True, slots=True)
class Channel:
    """One channel; every element of an array of channels is a channel."""

    name: str
    broadcast: bool
    urgent: bool


@dataclass(frozen=True, slots=True, eq=False)
class Location:
    """A location of a process, with its compiled invariant."""

    name: str
    index: int
    urgent: bool
    committed: bool
    invariant: Condition
    effects: Effects = field(repr=False)
    drawn: DrawnLocation = field(repr=False)


@dataclass(frozen=True, slots=True, eq=False)
class Edge:
    """An edge of a process with fixed values of its ``select``; there is one edge per combination of values.

    Attributes:
        process, index: the edge is ``network.processes[process].edges[index]``.
        source, target: numbers of locations.
        direction: ``!`` sends, ``?`` receives, empty without synchronisation.
        channel: number of the channel, or a function of the values; None without synchronisation.
        channels: all channels that ``channel`` can be.
        update: changes values (a list or an array) in place and appends ``(clock, value)`` for every clock that it
            sets.
        resets: clocks that the update sets in every state.
        selected: values of the names of ``select``.
        asks: the variables and clocks that guard and channel read.
        effects: the names that guard, channel and update read and write.
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
    """Return the names that these processes read and write, all together."""
    total = Effects()
    for process in processes:
        for location in process.locations:
            total.add(location.effects)
        for edge in process.edges:
            total.add(edge.effects)
    return total


@dataclass(frozen=True, slots=True, eq=False)
class Network:
    """All processes of the ``system`` line, with the variables, clocks and channels that they share.

    Attributes:
        document: the file from which the network was made.
        clocks: names; number 0 is the reference clock of zones and always zero.
        offsets: offsets of the values by name, in order: ``ee``, ``evidence[0]``, ``Gripper.i``.
        constants: the global constants with their values.
        replaced: initialisers in the file that given constants replace, and the new text.
        derived: cache of results computed from the network, shared by all users.
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
        """Return the offset of ``evidence[1]`` or ``Gripper.i`` in the values.

        Raises:
            UsageError: no variable of that name.
        """
        if name not in self.offsets:
            todo = did_you_mean(name, self.offsets)
            raise UsageError(f"The network has no variable '{name}'.", todo=todo)
        return self.offsets[name]

    def variable(self, offset: int) -> Variable:
        """Return the variable that a value belongs to."""
        return next(v for v in reversed(self.variables) if v.offset <= offset)

    def broadcast_by_clock(self, edge: Edge) -> bool:
        """Return whether clocks decide if a process receives a broadcast on this edge."""
        received = edge.direction == "?" and edge.guard.clocks and not edge.guard.never
        return bool(received) and any(self.channels[number].broadcast for number in edge.channels)

    def refuse_broadcast_by_clock(self, processes: Iterable[Process], where: str) -> None:
        """Raise ModelError if clocks decide whether one of the processes receives a broadcast."""
        for edge in (edge for process in processes for edge in process.edges):
            if self.broadcast_by_clock(edge):
                what = f"a clock guard on a receiver of a broadcast channel, in {where}"
                todo = "Receive it without the guard, and test the clock on the edges out of a committed location."
                raise refused(edge.guard.clocks[0].span, what, todo)

    def scalar(self, offset: int) -> Type:
        """Return the type of one value, with its own range."""
        variable = self.variable(offset)
        if not variable.type.fields:
            return variable.type.scalar
        return next(islice(variable.type.scalars(), offset - variable.offset, None))[1]

    def process(self, name: str) -> Process:
        """Return a process by its name.

        Raises:
            UsageError: there is none.
        """
        for process in self.processes:
            if process.name == name:
                return process
        todo = did_you_mean(name, (process.name for process in self.processes))
        raise UsageError(f"The network has no process '{name}'.", todo=todo)
