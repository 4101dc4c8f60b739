"""The values of a state as bytes: an eighth of the memory of a tuple, hashed and compared at the speed of memory."""

from __future__ import annotations

from array import array
from collections.abc import Callable
from struct import Struct

from timed_automata.network import Network


class Packing:
    """Packs values into as many bytes each as the ranges of the variables need."""

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
