"""Converts an execution to a snapshot and back: names instead of numbers; a snapshot that does not fit is refused."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from timed_automata.errors import UsageError
from timed_automata.execute._observations import ExecutionSnapshot
from timed_automata.network import Network, State


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
        kind, value = network.variable(offset).type, snapshot.variables[name]
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
