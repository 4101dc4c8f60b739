"""Types of the modelling language: kind, bounds, and array dimensions with their index ranges."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import prod
from typing import Literal, NamedTuple

TypeKind = Literal["int", "bool", "clock", "chan", "void"]
INT_LOW, INT_HIGH = -32768, 32767  # UPPAAL's int


class Dimension(NamedTuple):
    """The index range of one array dimension, both ends included."""

    low: int
    high: int

    @property
    def size(self) -> int:
        """Number of indices."""
        return self.high - self.low + 1


@dataclass(frozen=True, slots=True)
class Type:
    """A type whose bounds and sizes are computed; ``low`` and ``high`` bound integers (0 and 1 for booleans).

    ``name`` is the one that a typedef gave it; a type is the same without.
    """

    kind: TypeKind
    low: int = INT_LOW
    high: int = INT_HIGH
    dimensions: tuple[Dimension, ...] = ()
    constant: bool = False
    broadcast: bool = False
    urgent: bool = False
    name: str = field(default="", compare=False)

    @property
    def size(self) -> int:
        """Number of scalars that a value of this type has."""
        return prod(dimension.size for dimension in self.dimensions)

    @property
    def element(self) -> Type:
        """The type of ``a[i]``."""
        return replace(self, dimensions=self.dimensions[1:])

    @property
    def scalar(self) -> Type:
        """The type of the innermost element."""
        return replace(self, dimensions=())

    @property
    def shape(self) -> tuple[int, ...]:
        """Sizes of the dimensions."""
        return tuple(dimension.size for dimension in self.dimensions)

    @property
    def default(self) -> int:
        """Initial value where none is written: zero, or the allowed value nearest to zero."""
        return min(max(0, self.low), self.high)

    @property
    def integral(self) -> bool:
        """True for int, bool, and arrays of them."""
        return self.kind in ("int", "bool")

    def __str__(self) -> str:
        name = self.kind if self.kind != "int" or self.low == INT_LOW else f"int[{self.low},{self.high}]"
        prefix = ("urgent " if self.urgent else "") + ("broadcast " if self.broadcast else "")
        return prefix + name + "".join(f"[{dimension.size}]" for dimension in self.dimensions)


INT = Type("int")
BOOL = Type("bool", 0, 1)
VOID = Type("void")
