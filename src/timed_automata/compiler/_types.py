"""Types of the modelling language: kind, bounds, and array dimensions with their index ranges."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from math import prod
from typing import Literal, NamedTuple

TypeKind = Literal["int", "bool", "clock", "chan", "void", "struct"]
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

    A structure has ``fields``, by name and type in their order; ``low`` and ``high`` bound all of them together.
    ``name`` is the one that a typedef gave it; a type is the same without.
    """

    kind: TypeKind
    low: int = INT_LOW
    high: int = INT_HIGH
    dimensions: tuple[Dimension, ...] = ()
    constant: bool = False
    broadcast: bool = False
    urgent: bool = False
    fields: tuple[tuple[str, Type], ...] = ()
    name: str = field(default="", compare=False)

    @classmethod
    def structure(cls, fields: tuple[tuple[str, Type], ...]) -> Type:
        """Return the type of a structure."""
        types = [type_ for _, type_ in fields]
        return cls("struct", min(each.low for each in types), max(each.high for each in types), fields=fields)

    @property
    def single(self) -> bool:
        """Whether a value is one scalar: neither an array nor a structure."""
        return not (self.dimensions or self.fields)

    @property
    def parts(self) -> list[tuple[str, Type]]:
        """The elements or the fields, as suffixes of the name (``[0]``, ``.a``) and types; none for a scalar."""
        if not self.dimensions:
            return [(f".{name}", type_) for name, type_ in self.fields]
        (low, high), element = self.dimensions[0], self.element
        return [(f"[{index}]", element) for index in range(low, high + 1)]

    def scalars(self, name: str = "") -> Iterator[tuple[str, Type]]:
        """Yield name and type of each scalar of a value in the order of their places: ``a[0].x``, ``a[0].y``, …"""
        if self.single:
            yield name, self
        for suffix, part in self.parts:
            yield from part.scalars(name + suffix)

    @property
    def size(self) -> int:
        """Number of scalars that a value of this type has."""
        one = sum(type_.size for _, type_ in self.fields) if self.fields else 1
        return one * prod(dimension.size for dimension in self.dimensions)

    @property
    def element(self) -> Type:
        """The type of ``a[i]``."""
        return replace(self, dimensions=self.dimensions[1:])

    @property
    def scalar(self) -> Type:
        """The type of the innermost element."""
        return replace(self, dimensions=())

    @property
    def shape(self) -> object:
        """Sizes of the dimensions, and the fields: values of equal shape can be compared as a whole."""
        return tuple(dimension.size for dimension in self.dimensions), self.fields

    def like(self, other: Type) -> bool:
        """Return whether each value of one type is one of the other: the same shape and ranges."""
        return (self.shape, self.low, self.high) == (other.shape, other.low, other.high)

    @property
    def default(self) -> int:
        """Initial value where none is written: zero, or the allowed value nearest to zero."""
        return min(max(0, self.low), self.high)

    @property
    def integral(self) -> bool:
        """True for int, bool, and structures and arrays of them."""
        return self.kind in ("int", "bool", "struct")

    def __str__(self) -> str:
        name = self.kind if self.kind != "int" or self.low == INT_LOW else f"int[{self.low},{self.high}]"
        name = self.name if self.fields and self.name else name
        prefix = ("urgent " if self.urgent else "") + ("broadcast " if self.broadcast else "")
        return prefix + name + "".join(f"[{dimension.size}]" for dimension in self.dimensions)


INT = Type("int")
BOOL = Type("bool", 0, 1)
VOID = Type("void")
