"""The discrete states of a network, each computed once: expressions are evaluated per discrete state, not per zone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from end_effector_hal.automata._constraints import Bound
from end_effector_hal.automata._network import Edge, Network, State
from end_effector_hal.automata.explore._listening import ListeningSemantics
from end_effector_hal.automata.explore._resting import Resting
from end_effector_hal.errors import RangeError


@dataclass(frozen=True, slots=True, eq=False)
class Label:
    """What a transition does to clocks, and who takes part; one object for all transitions that are alike.

    Attributes:
        edges: participants, the sender first.
        channel: number of the channel; None without synchronisation.
        guard: what the clocks must satisfy.
        resets: what they are set to.
    """

    edges: tuple[Edge, ...]
    channel: int | None
    guard: tuple[Bound, ...]
    resets: Mapping[int, int]


class Move(NamedTuple):
    """A transition out of a discrete state.

    ``target`` is None where an update leaves the range of a variable; then ``error`` says which.
    """

    label: Label
    target: Discrete | None
    error: RangeError | None = None

    @property
    def edges(self) -> tuple[Edge, ...]:
        """Participants, the sender first."""
        return self.label.edges

    @property
    def channel(self) -> int | None:
        """Number of the channel; None without synchronisation."""
        return self.label.channel

    @property
    def guard(self) -> tuple[Bound, ...]:
        """What the clocks must satisfy."""
        return self.label.guard

    @property
    def resets(self) -> Mapping[int, int]:
        """What clocks are set to."""
        return self.label.resets


class Discrete:
    """A discrete state with its moves, and whether time may pass in it."""

    __slots__ = ("_moves", "_space", "_transitions", "delays", "invariant", "state")

    def __init__(self, space: DiscreteSpace, state: State) -> None:
        self._space, self.state = space, state
        self.delays, self.invariant = space.resting.at(state)
        self._moves: tuple[Move, ...] | None = None
        self._transitions = None
        if self.delays and space.urgent:
            self._transitions = tuple(space.semantics.transitions(state))
            self.delays = not any(channel in space.urgent for _, _, channel in self._transitions)

    @property
    def moves(self) -> tuple[Move, ...]:
        """All transitions, whatever the clocks say; those into a violated data invariant left out."""
        if self._moves is None:
            space = self._space
            transitions = self._transitions or space.semantics.transitions(self.state)
            moves = [space.move(self.state, *transition) for transition in transitions]
            self._moves = tuple(move for move in moves if move is not None)
            self._transitions = None
        return self._moves

    def forget(self) -> None:
        """Let go of the moves; they are computed again when they are asked for."""
        self._moves = None


class DiscreteSpace:
    """All discrete states met so far. One of these serves any number of queries about a network."""

    def __init__(self, network: Network, semantics: ListeningSemantics | None = None) -> None:
        self.network = network
        self.semantics = semantics or ListeningSemantics(network)
        self.urgent = {number for number, channel in enumerate(network.channels) if channel.urgent}
        self.resting = Resting(network)
        self._states: dict[State, Discrete | None] = {}
        self._labels: dict[object, Label] = {}
        self._checked = any(
            location.invariant.data is not None or location.invariant.never
            for process in network.processes
            for location in process.locations
        )

    def __len__(self) -> int:
        return len(self._states)

    def forget(self) -> None:
        """Let go of all states."""
        for discrete in self._states.values():
            if discrete is not None:
                discrete.forget()
        self._states.clear()

    def at(self, state: State) -> Discrete | None:
        """A discrete state, None if the data part of an invariant does not hold in it."""
        try:
            return self._states[state]
        except KeyError:
            state = self.resting.shared(state)
            allowed = not self._checked or self.semantics.allowed(state)
            discrete = self._states[state] = Discrete(self, state) if allowed else None
            return discrete

    def move(
        self, state: State, edges: tuple[Edge, ...], bounds: tuple[Bound, ...], channel: int | None
    ) -> Move | None:
        """What a transition leads to; None if the data part of an invariant does not hold there."""
        try:
            after, resets = self.semantics.fire(state, edges)
        except RangeError as error:
            return Move(Label(edges, channel, bounds, {}), None, error)
        target = self.at(after)
        if target is None:
            return None
        key = (edges, channel, bounds, resets)
        label = self._labels.get(key)
        if label is None:
            label = self._labels[key] = Label(edges, channel, bounds, dict(resets))
        return Move(label, target)
