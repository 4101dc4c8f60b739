"""A location of each process: what depends on their locations alone is found once."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from timed_automata.compiler import Bound, ClockConstraint, Values
from timed_automata.network import Network


class LocationVector:
    """A location of each process; one object for each combination that was met.

    Attributes:
        locations: them, as numbers.
        delays: whether no urgent or committed location stops time.
        invariant: upper bounds of clocks, where they are the same whatever the values; None otherwise.
        states: for the user, what is known of the discrete states here, by their packed values.
    """

    __slots__ = ("_parts", "delays", "invariant", "locations", "states")

    def __init__(self, network: Network, locations: tuple[int, ...]) -> None:
        found = [process.locations[at] for process, at in zip(network.processes, locations, strict=True)]
        self.locations = locations
        self.delays = not any(at.urgent or at.committed for at in found)
        self._parts: tuple[ClockConstraint, ...] = tuple(
            part for location in found for part in location.invariant.clocks
        )
        fixed = tuple(bound for part in self._parts if (bound := part.fixed) is not None)
        self.invariant = fixed if len(fixed) == len(self._parts) else None
        self.states: dict[bytes, Any] = {}

    def invariant_at(self, values: Values) -> tuple[Bound, ...]:
        """The upper bounds of clocks in a discrete state."""
        return tuple(part.at(values) for part in self._parts)


class LocationVectors:
    """All location vectors of a network that were met."""

    def __init__(self, network: Network) -> None:
        self._network = network
        self._known: dict[tuple[int, ...], LocationVector] = {}

    def __iter__(self) -> Iterator[LocationVector]:
        return iter(self._known.values())

    def at(self, locations: tuple[int, ...]) -> LocationVector:
        """The one object for these locations."""
        found = self._known.get(locations)
        if found is None:
            found = self._known[locations] = LocationVector(self._network, locations)
        return found

    def moved(self, vector: LocationVector, targets: Iterable[tuple[int, int]]) -> LocationVector:
        """Where some processes, by their numbers, are in other locations."""
        locations = list(vector.locations)
        for process, target in targets:
            locations[process] = target
        return self.at(tuple(locations))
