"""Variables, clocks and channels get their places in the network."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

from timed_automata.compiler import Type
from timed_automata.network._network import Channel, Variable


def element_names(name: str, type_: Type) -> Iterator[str]:
    """``a[0][0]``, ``a[0][1]``, … in row-major order; the name itself for a scalar."""
    for indices in product(*(range(low, high + 1) for low, high in type_.dimensions)):
        yield name + "".join(f"[{index}]" for index in indices)


class Places:
    """What has been given a place so far. Clock 0 is the reference clock, always zero."""

    def __init__(self) -> None:
        self.variables: list[Variable] = []
        self.offsets: dict[str, int] = {}
        self.initial: list[int] = []
        self.clocks: list[str] = ["0"]
        self.channels: list[Channel] = []

    def variable(self, name: str, type_: Type, values: list[int]) -> int:
        """A variable with its initial values; where it stands among the values."""
        offset = len(self.initial)
        self.variables.append(Variable(name, type_, offset))
        self.offsets |= {element: offset + n for n, element in enumerate(element_names(name, type_))}
        self.initial += values
        return offset

    def clock(self, name: str, type_: Type) -> int:
        """A clock or an array of clocks; the number of the first."""
        self.clocks += element_names(name, type_)
        return len(self.clocks) - type_.size

    def channel(self, name: str, type_: Type) -> int:
        """A channel or an array of channels; the number of the first."""
        self.channels += [Channel(each, type_.broadcast, type_.urgent) for each in element_names(name, type_)]
        return len(self.channels) - type_.size
