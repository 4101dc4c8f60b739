"""The discrete states of a network, each computed once: expressions are evaluated per discrete state, not per zone."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from timed_automata.compiler import Bound
from timed_automata.errors import RangeError
from timed_automata.explore.states._cached_semantics import CachedSemantics
from timed_automata.explore.states._firing import Action, Firing
from timed_automata.explore.states._location_vector import LocationVector, LocationVectors
from timed_automata.explore.states._packing import Packing
from timed_automata.network import Edge, Network, State, Transition


class Move(NamedTuple):
    """A transition out of a discrete state.

    ``target`` is None where an update leaves the range of a variable; then ``error`` says which.
    """

    action: Action
    target: DiscreteState | None
    error: RangeError | None = None

    @property
    def edges(self) -> tuple[Edge, ...]:
        """Participants, the sender first."""
        return self.action.edges

    @property
    def channel(self) -> int | None:
        """Number of the channel; None without synchronisation."""
        return self.action.channel

    @property
    def guard(self) -> tuple[Bound, ...]:
        """What the clocks must satisfy."""
        return self.action.guard

    @property
    def resets(self) -> Mapping[int, int]:
        """What clocks are set to."""
        return self.action.resets


Arc = tuple[Action, "DiscreteState | None", RangeError | None]


class DiscreteState:
    """A discrete state with its moves, and whether time may pass in it."""

    __slots__ = ("_moves", "_packed", "_space", "_transitions", "delays", "invariant", "vector")

    def __init__(self, space: DiscreteSpace, vector: LocationVector, packed: bytes) -> None:
        self._space, self.vector, self._packed = space, vector, packed
        self._moves: tuple[Move, ...] | None = None
        self.invariant = (
            vector.invariant if vector.invariant is not None else space.invariant(self.state, vector)
        )
        self.delays = vector.delays
        self._transitions: list[Transition] | None = None  # found already
        if self.delays and space.urgent:
            self._transitions = list(space.semantics.transitions(self.state))
            self.delays = not any(channel in space.urgent for _, _, channel in self._transitions)

    @property
    def state(self) -> State:
        """Locations and values."""
        return State(self.vector.locations, self._space.packing.unpack(self._packed))

    @property
    def moves(self) -> tuple[Move, ...]:
        """All transitions, whatever the clocks say; those into a violated data invariant left out."""
        if self._moves is None:
            self._moves = tuple(Move(*arc) for arc in self.arcs())
        return self._moves

    def arcs(self) -> Iterator[Arc]:
        """The same, as plain tuples that are not kept: action, target and error of a move."""
        space, vector, packed = self._space, self.vector, self._packed
        firings, transitions = space.firings, self._transitions
        self._transitions = None
        for edges, bounds, channel in transitions or space.semantics.transitions(self.state):
            firing = firings.get(edges) or space.firing(edges)
            try:
                after, values, resets = firing(vector, packed)
            except RangeError as error:
                yield firing.action(bounds, channel, ()), None, error
                continue
            try:
                target = after.states[values]
            except KeyError:
                target = space.met(after, values)
            if target is not None:
                yield firing.action(bounds, channel, resets), target, None

    def forget(self) -> None:
        """Drop the moves; they are computed again when they are asked for."""
        self._moves = None


class DiscreteSpace:
    """All discrete states met so far. One of these serves any number of queries about a network."""

    def __init__(self, network: Network, semantics: CachedSemantics | None = None) -> None:
        self.network = network
        self.semantics = semantics or CachedSemantics(network)
        self.urgent = {number for number, channel in enumerate(network.channels) if channel.urgent}
        self.packing, self.vectors = Packing(network), LocationVectors(network)
        self.firings: dict[tuple[Edge, ...], Firing] = {}
        self._invariants: dict[tuple[Bound, ...], tuple[Bound, ...]] = {}
        self._checked = any(
            location.invariant.data is not None or location.invariant.never
            for process in network.processes
            for location in process.locations
        )

    def __len__(self) -> int:
        return sum(len(vector.states) for vector in self.vectors)

    def forget(self) -> None:
        """Drop all states."""
        for vector in self.vectors:
            for discrete in vector.states.values():
                if discrete is not None:
                    discrete.forget()
            vector.states.clear()

    def at(self, state: State) -> DiscreteState | None:
        """A discrete state, None if the data part of an invariant does not hold in it."""
        vector, packed = self.vectors.at(state.locations), self.packing.pack(state.values)
        return vector.states[packed] if packed in vector.states else self.met(vector, packed)

    def met(self, vector: LocationVector, packed: bytes) -> DiscreteState | None:
        """The same for a state that was not met before."""
        discrete: DiscreteState | None = None
        if not self._checked or self.semantics.allowed(State(vector.locations, self.packing.unpack(packed))):
            discrete = DiscreteState(self, vector, packed)
        vector.states[packed] = discrete
        return discrete

    def firing(self, edges: tuple[Edge, ...]) -> Firing:
        """The firing of edges that were not taken together before."""
        firing = Firing(edges, self.vectors, self.packing, self.semantics.fixed)
        self.firings[edges] = firing
        return firing

    def invariant(self, state: State, vector: LocationVector) -> tuple[Bound, ...]:
        """Upper bounds of clocks in a discrete state; equal ones are one object."""
        bounds = vector.invariant_at(state.values)
        return self._invariants.setdefault(bounds, bounds)
