"""The semantics of a network, defined once: the discrete transitions of a state, and their results.

UPPAAL's rules. Binary synchronisation: one sender and one receiver of another process. Broadcast: one sender, and one
receiving edge of every other process that has any whose guard holds then; a sender never waits. Guards of all
participants are evaluated before any update; the sender's update comes first, then the receivers' in the order of the
system line. While any process is in a committed location, only transitions with a participant in a committed location
are possible. A transition into a violated invariant is disabled.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from itertools import product
from typing import Any, NamedTuple

from timed_automata.compiler import Bound, Condition, Values
from timed_automata.network._network import Edge, Network, State


class Transition(NamedTuple):
    """A discrete transition whose data guards hold.

    Attributes:
        edges: edges of the participants, the sender first.
        bounds: clock guards of all participants, a conjunction; evaluated before the transition. Where clocks decide
            whether a process receives a broadcast, there is a transition with it and one or more without it, whose
            bounds exclude each other.
        channel: number of the channel; None without synchronisation.
    """

    edges: tuple[Edge, ...]
    bounds: tuple[Bound, ...]
    channel: int | None


class Fired(NamedTuple):
    """The result of a transition: the next discrete state, and the clocks set, in order, with their values."""

    state: State
    resets: tuple[tuple[int, int], ...]


class _ClockGuards:
    """The clock constraints of a condition in a discrete state; evaluated once if they do not depend on the state."""

    def __init__(self, condition: Condition) -> None:
        self._constraints = condition.clocks
        fixed = [constraint.fixed for constraint in condition.clocks]
        known = [bound for bound in fixed if bound is not None]
        self._fixed = tuple(known) if len(known) == len(fixed) else None

    def at(self, values: Values) -> tuple[Bound, ...]:
        if self._fixed is not None:
            return self._fixed
        return tuple(constraint.at(values) for constraint in self._constraints)


_Answer = tuple[tuple[Edge, ...], tuple[Bound, ...]]  # the edges that receive, and their guards
_NOBODY: tuple[_Answer, ...] = (((), ()),)
_NONE: tuple[tuple[Edge, tuple[Bound, ...]], ...] = ()
_Receiver = tuple[Edge, Callable[[Values], Any] | None, _ClockGuards, Callable[[Values], int] | None]


class _Outgoing:
    """The edges that leave a location, grouped by synchronisation; edges that can never be taken are left out."""

    def __init__(self, edges: Sequence[Edge]) -> None:
        possible = [edge for edge in edges if not edge.guard.never]
        self.active = [
            (edge, edge.guard.data, _ClockGuards(edge.guard)) for edge in possible if edge.direction != "?"
        ]
        self._receiving: dict[int, list[_Receiver]] = {}
        for edge in possible:
            receiver = (edge, edge.guard.data, _ClockGuards(edge.guard), _computed(edge))
            for channel in edge.channels if edge.direction == "?" else ():
                self._receiving.setdefault(channel, []).append(receiver)
        self._always = {
            channel: [(edge, clocks.at(())) for edge, _, clocks, _ in found]
            for channel, found in self._receiving.items()
            if not any(data or edge.guard.clocks or computed for edge, data, _, computed in found)
        }

    @property
    def received(self) -> Iterable[int]:
        """Channels on which the edges can receive."""
        return self._receiving

    def receivers(self, channel: int, values: Values) -> Sequence[tuple[Edge, tuple[Bound, ...]]]:
        always = self._always.get(channel)
        if always is not None:
            return always
        receiving = self._receiving.get(channel)
        if receiving is None:
            return _NONE
        return [
            (edge, clocks.at(values))
            for edge, data, clocks, computed in receiving
            if (data is None or data(values)) and (computed is None or computed(values) == channel)
        ]


class _Initiator(NamedTuple):
    """An edge that may start a transition; ``free`` is true if the other participants do not matter."""

    process: int
    free: bool
    edge: Edge
    data: Callable[[Values], Any] | None
    clocks: _ClockGuards


class _Initiators(NamedTuple):
    """The committed processes, and the edges that may start a transition."""

    committed: list[int]
    edges: list[_Initiator]


def _with_absence(
    enabled: Sequence[tuple[Edge, tuple[Bound, ...]]],
) -> Iterator[tuple[Edge | None, tuple[Bound, ...]]]:
    """Yield the ways in which a process can receive a broadcast, and None where the clock guards of all its edges
    fail: these bounds exclude each other.
    """
    yield from enabled
    absent: list[tuple[Bound, ...]] = [()]
    for _, bounds in enabled:
        fails = [
            (*bounds[:number], contrary) for number, bound in enumerate(bounds) for contrary in bound.contrary
        ]
        absent = [(*before, *after) for before in absent for after in fails]
    for bounds in absent:
        yield None, bounds


def _computed(edge: Edge) -> Callable[[Values], int] | None:
    return edge.channel if callable(edge.channel) else None


class Semantics:
    """The transitions of a network, or of some of its processes if the others belong to an environment.

    Args:
        network: a loaded network.
        processes: indices of the processes that move; all by default. The others keep their locations.
    """

    def __init__(self, network: Network, processes: Collection[int] | None = None) -> None:
        self.network = network
        self.initial = network.initial
        self._processes = tuple(range(len(network.processes)) if processes is None else sorted(processes))
        self._locations = [process.locations for process in network.processes]
        self._outgoing = [
            [
                _Outgoing([e for e in process.edges if e.source == location.index])
                for location in process.locations
            ]
            for process in network.processes
        ]
        received_in = [
            {channel for edge in process.edges if edge.direction == "?" for channel in edge.channels}
            for process in network.processes
        ]
        self._listeners = [
            [
                (process, self._outgoing[process])
                for process in self._processes
                if channel in received_in[process]
            ]
            for channel in range(len(network.channels))
        ]
        self._broadcast = [channel.broadcast for channel in network.channels]
        self._timed = {
            channel
            for process in self._processes
            for edge in network.processes[process].edges
            if network.broadcast_by_clock(edge)
            for channel in edge.channels
        }
        self._known: dict[tuple[int, ...], _Initiators] = {}
        self._invariants = [
            [_ClockGuards(location.invariant) for location in process.locations]
            for process in network.processes
        ]
        self._urgent = {number for number, channel in enumerate(network.channels) if channel.urgent}

    def transitions(self, state: State) -> Iterator[Transition]:
        """Yield all transitions whose data guards hold and that committed locations allow.

        They come in the order of the system line (of the sender), then of the edges in the file, then of the
        receivers. The caller must check clock guards and the invariants of the target.

        Raises:
            RangeError: a guard divides by zero, or has an index outside of its array.
        """
        values = state.values
        committed, initiators = self._initiators(state.locations)
        for process, free, edge, data, clocks in initiators:
            if data is not None and not data(values):
                continue
            channel = edge.channel
            if channel is None:
                yield Transition((edge,), clocks.at(values), None)
                continue
            if not isinstance(channel, int):
                channel = channel(values)
            for receivers, bounds in self._receivers(state, channel, process):
                if free or any(other.process in committed for other in receivers):
                    yield Transition((edge, *receivers), clocks.at(values) + bounds, channel)

    def _initiators(self, locations: tuple[int, ...]) -> _Initiators:
        """Return the committed processes, and the edges that can start a transition; cached."""
        found = self._known.get(locations)
        if found is None:
            committed = [p for p in self._processes if self._locations[p][locations[p]].committed]
            heard = {channel for p in committed for channel in self._outgoing[p][locations[p]].received}
            found = self._known[locations] = _Initiators(
                committed,
                [
                    _Initiator(process, not committed or process in committed, *active)
                    for process in self._processes
                    if not committed or process in committed or heard
                    for active in self._outgoing[process][locations[process]].active
                    if not committed or process in committed or not heard.isdisjoint(active[0].channels)
                ],
            )
        return found

    def received(self, state: State, channel: int) -> Iterator[Transition]:
        """Yield the transitions that receive a broadcast of the environment, one per choice of receivers, in file
        order.
        """
        for receivers, bounds in self._receivers(state, channel, None):
            yield Transition(receivers, bounds, channel)

    def _receivers(self, state: State, channel: int, sender: int | None) -> Sequence[_Answer]:
        """Return all choices of the participants besides the sender."""
        locations, values = state
        choices = [
            enabled
            for process, outgoing in self._listeners[channel]
            if process != sender and (enabled := outgoing[locations[process]].receivers(channel, values))
        ]
        if not self._broadcast[channel]:
            return [((edge,), bounds) for enabled in choices for edge, bounds in enabled]
        if not choices:
            return _NOBODY
        if channel in self._timed:
            return [
                (
                    tuple([edge for edge, _ in choice if edge is not None]),
                    tuple([b for _, bounds in choice for b in bounds]),
                )
                for choice in product(*map(_with_absence, choices))
            ]
        if len(choices) == 1:
            return [((edge,), bounds) for edge, bounds in choices[0]]
        return [
            (tuple([edge for edge, _ in choice]), tuple([b for _, bounds in choice for b in bounds]))
            for choice in product(*choices)
        ]

    def fire(self, state: State, edges: Sequence[Edge], writes: Mapping[int, int] | None = None) -> Fired:
        """Take a transition; ``writes`` (by offset) replace the update of a sender in the environment.

        Raises:
            RangeError: an assignment is out of range.
        """
        locations, values = list(state.locations), list(state.values)
        resets: list[tuple[int, int]] = []
        for offset, value in (writes or {}).items():
            values[offset] = value
        for edge in edges:
            locations[edge.process] = edge.target
            if edge.update is not None:
                edge.update(values, resets)
        return Fired(State(tuple(locations), tuple(values)), tuple(resets))

    def invariant(self, state: State) -> list[Bound]:
        """Return the bounds of clocks in this state, a conjunction. A lower bound can be violated only on entry."""
        locations, values = state
        return [
            bound
            for process in self._processes
            for bound in self._invariants[process][locations[process]].at(values)
        ]

    def allowed(self, state: State) -> bool:
        """Return whether the data part of all invariants holds; otherwise no transition leads to this state."""
        locations, values = state
        return all(self._locations[p][locations[p]].invariant.holds(values) for p in self._processes)

    def may_delay(self, state: State) -> bool:
        """Return whether time may pass: no urgent or committed location, no synchronisation on an urgent channel."""
        locations = [self._locations[process][state.locations[process]] for process in self._processes]
        if any(location.urgent or location.committed for location in locations):
            return False
        return not self._urgent or not any(t.channel in self._urgent for t in self.transitions(state))

    def committed(self, state: State) -> bool:
        """Return whether any process is in a committed location."""
        return any(self._locations[p][state.locations[p]].committed for p in self._processes)
