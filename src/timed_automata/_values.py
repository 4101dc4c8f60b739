"""What an expression compiles to, with the interval that it lies in: checks that cannot fail are left out."""

from __future__ import annotations

from dataclasses import dataclass

from timed_automata._scope import Storage
from timed_automata._types import Type

WIDE = 2**31  # what UPPAAL computes with


@dataclass(frozen=True, slots=True)
class Value:
    """An integer: Python source and the interval that it lies in."""

    source: str
    low: int = -WIDE
    high: int = WIDE - 1
    truth: bool = False  # only whether it is zero is meaningful: a Python bool, or any operand of and/or
    known: int | None = None

    @classmethod
    def of(cls, number: int) -> Value:
        """A number."""
        return cls(str(number) if number >= 0 else f"({number})", number, number, known=number)

    @property
    def integer(self) -> Value:
        """The same as a number, 0 or 1 for a truth."""
        return Value(f"(1 if {self.source} else 0)", 0, 1) if self.truth else self

    @property
    def boolean(self) -> Value:
        """0 or 1."""
        if self.known is not None:
            return Value.of(int(self.known != 0))
        return (
            self
            if not self.truth and self.low >= 0 and self.high <= 1
            else Value(self.source, truth=True).integer
        )

    def within(self, low: int, high: int) -> bool:
        """Whether it can never be outside."""
        return low <= self.low and self.high <= high


@dataclass(frozen=True, slots=True)
class Place:
    """A scalar or an array in a container: a fixed offset plus a computed one (source, may be empty)."""

    storage: Storage
    type: Type
    offset: int = 0
    computed: str = ""
    values: tuple[int, ...] | None = None  # of a constant

    @property
    def start(self) -> str:
        """Source of the index of its first scalar."""
        base = self.storage.base
        parts = [base] if isinstance(base, str) else []
        fixed = self.offset + (base if isinstance(base, int) else 0)
        if fixed or not (parts or self.computed):
            parts.append(str(fixed))
        return " + ".join([*parts, self.computed] if self.computed else parts)

    @property
    def source(self) -> str:
        """Source of a scalar."""
        return f"{self.storage.container}[{self.start}]"

    @property
    def slice(self) -> str:
        """Source of all scalars of an array, as a list."""
        start = self.start
        end = f"{start} + {self.type.size}" if not start.isdigit() else str(int(start) + self.type.size)
        return f"[*{self.storage.container}[{start}:{end}]]"


@dataclass(frozen=True, slots=True)
class Indexed:
    """A clock or a channel: the number of the first of its array of ``size``, plus a computed offset."""

    name: str
    type: Type
    base: int
    offset: int = 0
    computed: str = ""
    size: int = 1

    @property
    def possible(self) -> range:
        """All numbers that it can be."""
        first = self.base + self.offset
        return range(self.base, self.base + self.size) if self.computed else range(first, first + 1)

    @property
    def source(self) -> str:
        """Source of its number."""
        return (
            f"{self.base + self.offset} + {self.computed}" if self.computed else str(self.base + self.offset)
        )
