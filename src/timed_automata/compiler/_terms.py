"""What a name or an index stands for: a value, variables in a container, or clocks and channels by number."""

from __future__ import annotations

from dataclasses import dataclass

from timed_automata.compiler._scope import Storage
from timed_automata.compiler._types import Type
from timed_automata.compiler._values import Value


@dataclass(frozen=True, slots=True)
class StorageTerm:
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
class IndexedTerm:
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


Term = Value | StorageTerm | IndexedTerm
