"""The discrete states of a network, computed once: expressions are evaluated per discrete state, not per zone.

A discrete state consists of a vector of locations, and the values of the variables as bytes.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from struct import Struct
from typing import Any, NamedTuple

from timed_automata.compiler import Bound, ClockConstraint, Values
from timed_automata.errors import RangeError
from timed_automata.explore.states._semantics import CachedSemantics
from timed_automata.network import Edge, Location, Network, State, Transition


class LocationFacts(NamedTuple):
    """The properties of a location that do not depend on the values.

    Attributes:
        delays: whether time may pass in it.
        clocks: clock constraints of its invariant.
        fixed: the bounds of its invariant if they are the same for all values, else None.
    """

    delays: bool
    clocks: tuple[ClockConstraint, ...]
    fixed: tuple[Bound, ...] | None

    @classmethod
    def of(cls, location: Location) -> LocationFacts:
        """Return the properties of a location."""
        clocks = tuple(location.invariant.clocks)
        fixed = tuple(bound for part in clocks if (bound := part.fixed) is not None)
        delays = not (location.urgent or location.committed)
        return cls(delays, clocks, fixed if len(fixed) == len(clocks) else None)


class LocationVector:
    """One location per process; every combination is one object, so that data that depends on it is computed once.

    Attributes:
        locations: the numbers of the locations.
        delays: whether no urgent or committed location stops time.
        invariant: bounds of clocks if they are the same for all values, else None.
        states: the discrete states with these locations, by packed values; filled by the user.
    """

    __slots__ = ("_parts", "delays", "invariant", "locations", "states")

    def __init__(self, locations: tuple[int, ...], facts: Sequence[LocationFacts]) -> None:
        self.locations, self.delays = locations, all(each.delays for each in facts)
        timed = [each for each in facts if each.clocks]
        self.invariant: tuple[Bound, ...] | None = None
        self._parts: tuple[ClockConstraint, ...] = ()
        if any(each.fixed is None for each in timed):
            self._parts = tuple([part for each in timed for part in each.clocks])
        else:
            self.invariant = tuple([bound for each in timed for bound in each.fixed or ()])
        self.states: dict[bytes, Any] = {}

    def invariant_at(self, values: Values) -> tuple[Bound, ...]:
        """Return the bounds of clocks in a discrete state."""
        return tuple([part.at(values) for part in self._parts])


class Packing:
    """Packs values into as few bytes per value as the ranges of the variables need.

    That takes an eighth of the memory of a tuple, and is hashed and compared at the speed of memory.
    """

    def __init__(self, network: Network) -> None:
        types = [variable.type for variable in network.variables]
        low = min((one.low for one in types), default=0)
        high = max((one.high for one in types), default=0)
        self._code = next(code for code in "bhiq" if -_half(code) <= low and high < _half(code))
        self.unpack: Callable[[bytes], tuple[int, ...]]  # bytes as values
        self.unpack = Struct(f"{len(network.initial.values)}{self._code}").unpack

    def pack(self, values: tuple[int, ...]) -> bytes:
        """Return the values as bytes."""
        return array(self._code, values).tobytes()

    def open(self, packed: bytes) -> array[int]:
        """Return a copy that can be changed in place; ``tobytes`` packs it again."""
        return array(self._code, packed)


def _half(code: str) -> int:
    """Return half the number of values that the type can hold."""
    return 1 << (array(code).itemsize * 8 - 1)


Resets = tuple[tuple[int, int], ...]


@dataclass(frozen=True, slots=True, eq=False)
class Action:
    """The effect of a transition on the clocks, and its participants; equal actions are one object.

    Attributes:
        edges: edges of the participants, the sender first.
        channel: number of the channel; None without synchronisation.
        guard: constraints on the clocks.
        resets: new values of the clocks that the transition sets.
    """

    edges: tuple[Edge, ...]
    channel: int | None
    guard: tuple[Bound, ...]
    resets: Mapping[int, int]


class Firing:
    """The joint effect of some edges, the sender's first; computed once, because many transitions share it."""

    __slots__ = ("_actions", "_after", "_edges", "_fixed", "_space", "_targets", "_updates")

    def __init__(self, edges: tuple[Edge, ...], space: DiscreteSpace) -> None:
        written = {name for edge in edges for name in edge.effects.writes}
        self._edges, self._space = edges, space
        self._targets = [(edge.process, edge.target) for edge in edges]
        self._updates = [edge.update for edge in edges if edge.update is not None]
        self._fixed = [(offset, value) for name, offset, value in space.semantics.fixed if name in written]
        self._after: dict[LocationVector, LocationVector] = {}
        self._actions: dict[object, Action] = {}

    def __call__(self, vector: LocationVector, packed: bytes) -> tuple[LocationVector, bytes, Resets]:
        """Return the next discrete state, and the clocks that are set, in order, with their values.

        Raises:
            RangeError: an assignment is out of range.
        """
        after = self._after.get(vector)
        if after is None:
            moved = list(vector.locations)
            for process, location in self._targets:
                moved[process] = location
            after = self._after[vector] = self._space.vector(tuple(moved))
        if not self._updates:
            return after, packed, ()
        resets: list[tuple[int, int]] = []
        values = self._space.packing.open(packed)
        for update in self._updates:
            update(values, resets)
        for offset, value in self._fixed:
            values[offset] = value
        return after, values.tobytes(), tuple(resets)

    def action(self, guard: tuple[Bound, ...], channel: int | None, resets: Resets) -> Action:
        """Return the action of a transition with these edges."""
        key = (guard, channel, resets)
        found = self._actions.get(key)
        if found is None:
            found = self._actions[key] = Action(self._edges, channel, guard, dict(resets))
        return found


class Move(NamedTuple):
    """A transition out of a discrete state.

    ``target`` is None if an update leaves the range of a variable; then ``error`` is the reason.
    """

    action: Action
    target: DiscreteState | None
    error: RangeError | None = None


Arc = tuple[Action, "DiscreteState | None", RangeError | None]


class DiscreteState:
    """A discrete state with its moves, and whether time may pass in it."""

    __slots__ = ("_arcs", "_space", "_transitions", "delays", "invariant", "packed", "vector")

    def __init__(self, space: DiscreteSpace, vector: LocationVector, packed: bytes) -> None:
        self._space, self.vector, self.packed = space, vector, packed
        self._arcs: tuple[Any, ...] | None = (
            None  # side by side, as a tuple for each takes more than the states
        )
        self.invariant = vector.invariant if vector.invariant is not None else space.invariant(vector, packed)
        self.delays = vector.delays
        self._transitions: list[Transition] | None = None  # found already
        if self.delays and space.urgent:
            self._transitions = list(space.semantics.transitions(self.state))
            self.delays = not any(channel in space.urgent for _, _, channel in self._transitions)

    @property
    def state(self) -> State:
        """Locations and values of the state."""
        return State(self.vector.locations, self._space.packing.unpack(self.packed))

    @property
    def endless(self) -> bool:
        """Whether time can pass without end."""
        return self.delays and all(bound.lower for bound in self.invariant)

    @property
    def moves(self) -> Iterator[Move]:
        """All transitions for any clock values, except those into a violated data invariant."""
        return (Move(*arc) for arc in self.kept_arcs())

    def kept_arcs(self) -> Iterable[Arc]:
        """Return the same as :meth:`arcs`, computed once and kept."""
        if self._arcs is None:
            self._arcs = tuple(chain.from_iterable(self.arcs()))
        parts = iter(self._arcs)
        return zip(parts, parts, parts, strict=True)

    def arcs(self) -> Iterator[Arc]:
        """Yield the moves as plain tuples, which are not kept: action, target and error."""
        space, vector, packed = self._space, self.vector, self.packed
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
        """Drop the moves; they are computed again when they are needed."""
        self._arcs = None


class DiscreteSpace:
    """All discrete states reached so far; it can serve any number of queries about a network."""

    def __init__(self, network: Network, semantics: CachedSemantics | None = None) -> None:
        self.network = network
        self.semantics = semantics or CachedSemantics(network)
        self.urgent = {number for number, channel in enumerate(network.channels) if channel.urgent}
        self.packing = Packing(network)
        self._facts = [
            [LocationFacts.of(location) for location in process.locations] for process in network.processes
        ]
        self._vectors: dict[tuple[int, ...], LocationVector] = {}
        self.firings: dict[tuple[Edge, ...], Firing] = {}
        self._invariants: dict[tuple[Bound, ...], tuple[Bound, ...]] = {}
        self._checked = any(
            location.invariant.data is not None or location.invariant.never
            for process in network.processes
            for location in process.locations
        )

    def __len__(self) -> int:
        return sum(len(vector.states) for vector in self._vectors.values())

    def drop(self, state: DiscreteState) -> None:
        """Drop a state; it is created again when it is reached again."""
        state.vector.states.pop(state.packed, None)
        state.forget()

    def forget(self) -> None:
        """Drop all states."""
        for vector in self._vectors.values():
            for discrete in vector.states.values():
                if discrete is not None:
                    discrete.forget()
            vector.states.clear()

    def vector(self, locations: tuple[int, ...]) -> LocationVector:
        """Return the unique object for these locations."""
        found = self._vectors.get(locations)
        if found is None:
            facts = [each[at] for each, at in zip(self._facts, locations, strict=True)]
            found = self._vectors[locations] = LocationVector(locations, facts)
            if found.invariant is not None:
                found.invariant = self._invariants.setdefault(found.invariant, found.invariant)
        return found

    def at(self, state: State) -> DiscreteState | None:
        """Return a discrete state, or None if the data part of an invariant does not hold in it."""
        vector, packed = self.vector(state.locations), self.packing.pack(state.values)
        return vector.states[packed] if packed in vector.states else self.met(vector, packed)

    def met(self, vector: LocationVector, packed: bytes) -> DiscreteState | None:
        """Create a discrete state that was not reached before; None if the data part of an invariant does not hold in
        it.
        """
        discrete: DiscreteState | None = None
        if not self._checked or self.semantics.allowed(State(vector.locations, self.packing.unpack(packed))):
            discrete = DiscreteState(self, vector, packed)
        vector.states[packed] = discrete
        return discrete

    def firing(self, edges: tuple[Edge, ...]) -> Firing:
        """Create the firing of edges that were not taken together before."""
        firing = self.firings[edges] = Firing(edges, self)
        return firing

    def invariant(self, vector: LocationVector, packed: bytes) -> tuple[Bound, ...]:
        """Return the bounds of clocks in a discrete state; equal bounds are one object."""
        bounds = vector.invariant_at(self.packing.unpack(packed))
        return self._invariants.setdefault(bounds, bounds)
