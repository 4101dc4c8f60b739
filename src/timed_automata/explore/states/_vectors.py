"""The parts of discrete states: location vectors, and values as bytes."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Sequence
from struct import Struct
from typing import Any, NamedTuple

from timed_automata.compiler import Bound, ClockConstraint, Values
from timed_automata.network import Location, Network


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
