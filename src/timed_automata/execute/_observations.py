"""The inputs and outputs of an execution: events, steps, observations and snapshots.

A snapshot contains names instead of numbers. A snapshot that does not fit the network is refused.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from timed_automata.errors import UsageError
from timed_automata.network import Change, Network, State


@dataclass(frozen=True, slots=True)
class Event:
    """A broadcast from the environment: its channel, and the interface variables that its sender writes."""

    channel: str
    writes: Mapping[str, int] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class TakenEdge:
    """A taken edge: its process, the names of its locations, its number and its position in the file."""

    process: str
    source: str
    target: str
    index: int
    where: str


@dataclass(frozen=True, slots=True)
class Step:
    """One discrete transition.

    Attributes:
        at: time at which it was taken, µs.
        due: time at which it had to be taken, µs; None for an event of the environment.
        late_us: delay after ``due``, µs.
        missed: it was taken later than the model allows (an invariant, or an upper bound of a guard).
        received: channel of the environment's event, if the step received one.
        sent: channel on which an executed process synchronised.
        edges: the edges of all participants, the sender first.
        changes: changes of variables, in the order of declaration.
    """

    at: int
    due: int | None
    late_us: int
    missed: bool
    received: str | None
    sent: str | None
    edges: tuple[TakenEdge, ...]
    changes: tuple[Change, ...]


@dataclass(frozen=True, slots=True)
class Reaction:
    """The result of an event: ``taken`` if a process received it, and all steps, including those due before it."""

    taken: bool
    steps: tuple[Step, ...]


@dataclass(frozen=True, slots=True)
class ExecutionSnapshot:
    """The state of an execution, sufficient to continue from it.

    The time since which a transition has been possible is not stored: between two calls only clocks make transitions
    due.

    Attributes:
        at: the latest time that the execution received, µs.
        entered: time at which the discrete state was entered, µs.
        locations: name of the current location, by process.
        variables: value, by name.
        zeros: instant at which a clock was zero, µs, by name of the clock.
    """

    at: int
    entered: int
    locations: Mapping[str, str]
    variables: Mapping[str, int]
    zeros: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class Begun:
    """Observation that an execution began at ``at`` µs with all clocks at zero and these values of the interface."""

    at: int
    writes: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class Written:
    """Observation that the environment set interface variables without an event."""

    at: int
    writes: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class Received:
    """Observation that an event of the environment arrived; if an edge received it, the next observation is
    that step.
    """

    at: int
    channel: str
    writes: Mapping[str, int]


Observation = Begun | Written | Received | Step
"""An observation of an execution from outside; their sequence is enough to judge whether it is a run of the network."""


class Resumed(NamedTuple):
    """A snapshot translated to the numbers of a network.

    Attributes:
        state: locations and values.
        zeros: instant at which a clock was zero, µs, by the number of the clock.
    """

    state: State
    zeros: list[int]


def snapshot_of(
    network: Network, state: State, zeros: Sequence[int], *, at: int, entered: int
) -> ExecutionSnapshot:
    """Return the snapshot as it is recorded; all times are in µs."""
    pairs = zip(network.processes, state.locations, strict=True)
    return ExecutionSnapshot(
        at=at,
        entered=entered,
        locations={process.name: process.locations[number].name for process, number in pairs},
        variables=dict(zip(network.offsets, state.values, strict=True)),
        zeros=dict(zip(network.clocks[1:], zeros[1:], strict=True)),
    )


def resume(network: Network, snapshot: ExecutionSnapshot) -> Resumed:
    """Translate the snapshot to numbers.

    Raises:
        UsageError: the snapshot belongs to another network, or contradicts itself.
    """
    _same_names("processes", snapshot.locations, [process.name for process in network.processes])
    _same_names("variables", snapshot.variables, network.offsets)
    _same_names("clocks", snapshot.zeros, network.clocks[1:])
    if snapshot.entered > snapshot.at or any(zero > snapshot.at for zero in snapshot.zeros.values()):
        raise UsageError("A recorded state contains a time later than its own stamp; the trace is damaged.")
    locations = []
    for process in network.processes:
        name = snapshot.locations[process.name]
        numbers = [location.index for location in process.locations if location.name == name]
        if len(numbers) != 1:
            raise UsageError(f"A recorded state has {process.name} in {name!r}, which is no location of it.")
        locations += numbers
    for name, offset in network.offsets.items():
        kind, value = network.scalar(offset), snapshot.variables[name]
        if not kind.low <= value <= kind.high:
            raise UsageError(f"A recorded state has {name} = {value}, which is out of its range.")
    values = tuple(snapshot.variables[name] for name in network.offsets)
    zeros = [snapshot.at, *(snapshot.zeros[name] for name in network.clocks[1:])]
    return Resumed(State(tuple(locations), values), zeros)


def _same_names(what: str, found: Iterable[str], expected: Iterable[str]) -> None:
    differing = sorted(set(found) ^ set(expected))
    if differing:
        raise UsageError(
            f"A recorded state is of another network: its {what} differ ({', '.join(differing[:3])})."
        )
