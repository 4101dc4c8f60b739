"""The discrete states of a network, each computed once: expressions are evaluated per discrete state, not per zone."""

from __future__ import annotations

from typing import NamedTuple

from end_effector_hal.automata._constraints import Bound
from end_effector_hal.automata._faults import RangeError
from end_effector_hal.automata._network import Edge, Network, State
from end_effector_hal.automata.explore._listening import ListeningSemantics


class Move(NamedTuple):
    """A transition out of a discrete state: what its clocks must satisfy and what they are set to.

    ``target`` is None where an update leaves the range of a variable; then ``error`` says which.
    """

    edges: tuple[Edge, ...]
    channel: int | None
    guard: tuple[Bound, ...]
    resets: dict[int, int]
    target: Discrete | None
    error: RangeError | None = None


class Discrete:
    """A discrete state with its moves, and whether time may pass in it."""

    __slots__ = ("_moves", "_space", "_transitions", "delays", "invariant", "state")

    def __init__(self, space: DiscreteSpace, state: State) -> None:
        self._space, self.state = space, state
        semantics = space.semantics
        self.invariant = tuple(semantics.invariant(state))
        self._moves: tuple[Move, ...] | None = None
        self._transitions = None
        self.delays = not space.hurries(state.locations)
        if self.delays and space.urgent:
            self._transitions = tuple(semantics.transitions(state))
            self.delays = not any(channel in space.urgent for _, _, channel in self._transitions)

    @property
    def moves(self) -> tuple[Move, ...]:
        """All transitions, whatever the clocks say; those into a violated data invariant left out."""
        if self._moves is None:
            transitions = self._transitions or self._space.semantics.transitions(self.state)
            self._moves = tuple(
                move
                for edges, bounds, channel in transitions
                if (move := self._move(edges, bounds, channel)) is not None
            )
            self._transitions = None
        return self._moves

    def _move(self, edges: tuple[Edge, ...], bounds: tuple[Bound, ...], channel: int | None) -> Move | None:
        semantics = self._space.semantics
        try:
            state, resets = semantics.fire(self.state, edges)
        except RangeError as error:
            return Move(edges, channel, bounds, {}, None, error)
        target = self._space.at(state)
        return None if target is None else Move(edges, channel, bounds, dict(resets), target)


class DiscreteSpace:
    """All discrete states met so far. One of these serves any number of queries about a network."""

    def __init__(self, network: Network) -> None:
        self.network = network
        self.semantics = ListeningSemantics(network)
        self.urgent = {number for number, channel in enumerate(network.channels) if channel.urgent}
        self._states: dict[State, Discrete | None] = {}
        self._hurries: dict[tuple[int, ...], bool] = {}
        self._checked = any(
            location.invariant.data is not None or location.invariant.never
            for process in network.processes
            for location in process.locations
        )

    def __len__(self) -> int:
        return len(self._states)

    def at(self, state: State) -> Discrete | None:
        """A discrete state, None if the data part of an invariant does not hold in it."""
        try:
            return self._states[state]
        except KeyError:
            allowed = not self._checked or self.semantics.allowed(state)
            discrete = self._states[state] = Discrete(self, state) if allowed else None
            return discrete

    def hurries(self, locations: tuple[int, ...]) -> bool:
        """Whether an urgent or a committed location stops time."""
        known = self._hurries.get(locations)
        if known is None:
            found = (
                process.locations[at] for process, at in zip(self.network.processes, locations, strict=True)
            )
            known = self._hurries[locations] = any(
                location.urgent or location.committed for location in found
            )
        return known
