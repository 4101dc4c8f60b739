"""What discrete states are made of: location vectors, and values as bytes."""

from __future__ import annotations

from array import array
from collections.abc import Callable
from struct import Struct
from typing import Any

from timed_automata.compiler import Bound, ClockConstraint, Values
from timed_automata.network import Network


class LocationVector:
    """A location of each process; one object for each combination that was met: what depends on it is found once.

    Attributes:
        locations: them, as numbers.
        delays: whether no urgent or committed location stops time.
        invariant: bounds of clocks, where they are the same whatever the values; None otherwise.
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
        """The bounds of clocks in a discrete state."""
        return tuple(part.at(values) for part in self._parts)


class Packing:
    """Packs values into as many bytes each as the ranges of the variables need.

    That is an eighth of the memory of a tuple, hashed and compared at the speed of memory.
    """

    def __init__(self, network: Network) -> None:
        types = [variable.type for variable in network.variables]
        low = min((one.low for one in types), default=0)
        high = max((one.high for one in types), default=0)
        self._code = next(code for code in "bhiq" if -_half(code) <= low and high < _half(code))
        self.unpack: Callable[[bytes], tuple[int, ...]]  # bytes as values
        self.unpack = Struct(f"{len(network.initial.values)}{self._code}").unpack

    def pack(self, values: tuple[int, ...]) -> bytes:
        """Values as bytes."""
        return array(self._code, values).tobytes()

    def open(self, packed: bytes) -> array[int]:
        """A copy to be changed in place; ``tobytes`` packs it again."""
        return array(self._code, packed)


def _half(code: str) -> int:
    """Half the number of values that the type can hold."""
    return 1 << (array(code).itemsize * 8 - 1)
