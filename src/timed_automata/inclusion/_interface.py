"""The interface of a comparison: the participating processes, their inputs, and the observed variables and channels."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from timed_automata.document import Span, did_you_mean, refused
from timed_automata.errors import UsageError
from timed_automata.network import Network, Process, effects_of


@dataclass(frozen=True, slots=True)
class Interface:
    """The interface between two networks.

    Attributes:
        environment: processes of the specification that are not specified: their events and writes are the inputs of
            both networks at the same instant.
        observed: variables of both networks, whole arrays or elements, whose changes are observed.
        outputs: broadcast channels of both networks whose synchronisations are observed.
        system: processes of the implementation that take part; None: all except those named as environment.
        before: channels on which the implementation receives an event at time 0, before the comparison begins.
        start: initial values that its variables get before that. A variable that neither a participating process nor
            the environment writes keeps its value.
    """

    environment: Collection[str] = ()
    observed: Collection[str] = ()
    outputs: Collection[str] = ()
    system: Collection[str] | None = None
    before: Sequence[str] = ()
    start: Mapping[str, int] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Side:
    """One of the two networks in the comparison.

    Attributes:
        network: the whole network.
        processes: numbers of the processes that take part.
        environment: numbers of the processes that send the inputs.
        observed: names and offsets of the observed variables.
        outputs: names by the number of the channel.
        index: places of its clocks in the zones of the comparison.
    """

    network: Network
    processes: tuple[int, ...]
    environment: frozenset[int]
    observed: tuple[tuple[str, int], ...]
    outputs: Mapping[int, str]
    index: Mapping[int, int]


def sides(implementation: Network, specification: Network, interface: Interface) -> tuple[Side, Side]:
    """Return both networks with the parts that are compared.

    Raises:
        UsageError: a network lacks something that the interface names.
        ModelError: a participating process uses urgent locations or channels, or an output waits for the environment.
    """
    environment = frozenset(specification.process(name).index for name in interface.environment)
    if interface.system is None:
        part = tuple(
            each.index for each in implementation.processes if each.name not in interface.environment
        )
    else:
        part = tuple(sorted(implementation.process(name).index for name in interface.system))
    every = tuple(range(len(specification.processes)))
    found: list[Side] = []
    place = 1
    for network, processes, inside in (
        (implementation, part, frozenset[int]()),
        (specification, every, environment),
    ):
        taking_part = [network.processes[number] for number in processes]
        _check(network, taking_part, inside)
        clocks = sorted(_clocks(taking_part))
        found.append(
            Side(
                network,
                processes,
                inside,
                tuple(_observed(network, interface.observed)),
                dict(_outputs(network, interface.outputs)),
                {clock: place + number for number, clock in enumerate(clocks)},
            )
        )
        place += len(clocks)
    ours, theirs = found
    if [name for name, _ in ours.observed] != [name for name, _ in theirs.observed]:
        raise UsageError("The observed variables have other sizes in the two networks.")
    return ours, theirs


def inputs(implementation: Side, specification: Side) -> list[tuple[int, int]]:
    """Return the variables that the environment writes and the implementation reads, as offsets in both networks.

    Raises:
        UsageError: the implementation writes one of them.
    """
    network = specification.network
    sending = [network.processes[number] for number in specification.environment]
    receiving = [implementation.network.processes[number] for number in implementation.processes]
    names, effects = effects_of(sending).writes, effects_of(receiving)
    if both := sorted(names & effects.writes):
        raise UsageError(f"'{both[0]}' is written by the environment and by the implementation.")
    return [
        (at, implementation.network.offsets[name])
        for name, at in network.offsets.items()
        if network.variable(at).name in names & effects.reads and name in implementation.network.offsets
    ]


def _clocks(processes: Iterable[Process]) -> set[int]:
    """Return the clocks that the processes test."""
    conditions = [
        condition
        for process in processes
        for condition in (
            *(location.invariant for location in process.locations),
            *(edge.guard for edge in process.edges if not edge.guard.never),
        )
    ]
    return {
        clock for condition in conditions for constraint in condition.clocks for clock in constraint.clocks
    }


def _observed(network: Network, names: Collection[str]) -> Iterable[tuple[str, int]]:
    for name in names:
        elements = [(each, at) for each, at in network.offsets.items() if each.partition("[")[0] == name]
        yield from elements or [(name, network.offset(name))]


def _outputs(network: Network, names: Collection[str]) -> Iterable[tuple[int, str]]:
    for name in names:
        found = [
            (number, channel.name)
            for number, channel in enumerate(network.channels)
            if name in (channel.name, channel.name.partition("[")[0])
        ]
        if not found:
            todo = did_you_mean(name, (channel.name for channel in network.channels))
            raise UsageError(f"The network has no channel '{name}'.", todo=todo)
        yield from found


def _check(network: Network, processes: Sequence[Process], environment: frozenset[int]) -> None:
    received = {
        channel
        for number in environment
        for edge in network.processes[number].edges
        if edge.direction == "?"
        for channel in edge.channels
    }
    network.refuse_broadcast_by_clock(processes, "a comparison of two networks")
    for process in processes:
        for location in process.locations:
            if location.urgent:
                raise _refused(location.drawn.place.whole, f"the urgent location '{location.name}'")
        for edge in process.edges:
            for number in edge.channels if edge.direction == "!" else ():
                channel = network.channels[number]
                if channel.urgent:
                    raise _refused(edge.span, f"'{channel.name}!' on an urgent channel")
                if number in received and process.index not in environment and not channel.broadcast:
                    raise _refused(edge.span, f"'{channel.name}!', an output that waits for the environment")


def _refused(span: Span, what: str) -> Exception:
    return refused(
        span, f"{what}, in a comparison of two networks", "Take committed locations and broadcast channels."
    )
