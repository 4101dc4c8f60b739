"""The names of a model, their meanings, and the scopes that hold them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from timed_automata.compiler._types import Type
from timed_automata.document import Span, did_you_mean, fault


@dataclass(frozen=True, slots=True)
class Constant:
    """A constant; ``values`` are flat in row-major order; ``container`` names the tuple in generated code."""

    name: str
    type: Type
    values: tuple[int, ...]
    container: str


@dataclass(frozen=True, slots=True)
class Storage:
    """Adjacent scalars in a container of the generated code.

    A variable of the network is stored in ``v`` at a fixed position, an array of a function in its own list, and an
    array passed by reference at the position in ``base`` (a Python name).
    """

    name: str
    type: Type
    container: str = "v"
    base: int | str = 0
    written: bool = True  # whether assignments are allowed

    @property
    def shared(self) -> bool:
        """True for a variable of the network, false for one of a function."""
        return self.container == "v" and isinstance(self.base, int)


@dataclass(frozen=True, slots=True)
class Local:
    """A scalar of a function, a quantifier or a loop, stored in a Python name."""

    name: str
    type: Type
    python: str
    written: bool = True


@dataclass(frozen=True, slots=True)
class ClockSymbol:
    """A clock or an array of clocks; ``base`` is the index of the first."""

    name: str
    type: Type
    base: int


@dataclass(frozen=True, slots=True)
class ChannelSymbol:
    """A channel or an array of channels; ``base`` is the index of the first."""

    name: str
    type: Type
    base: int


@dataclass(frozen=True, slots=True)
class Alias:
    """A name given by typedef."""

    name: str
    type: Type


@dataclass(slots=True)
class Effects:
    """The variables and clocks of the network, by name, that a piece of code reads and writes."""

    reads: set[str] = field(default_factory=set)
    writes: set[str] = field(default_factory=set)
    repeats: int = 1
    """How often the innermost part is evaluated: the product of the ranges of nested quantifiers and loops."""

    def add(self, other: Effects) -> None:
        """Add the effects of another piece of code."""
        self.reads |= other.reads
        self.writes |= other.writes


@dataclass(frozen=True, slots=True)
class FormalParameter:
    """A parameter of a function."""

    name: str
    type: Type
    reference: bool


@dataclass(frozen=True, slots=True)
class Function:
    """A function, its name in generated code, and its effects on the network."""

    name: str
    parameters: tuple[FormalParameter, ...]
    result: Type
    python: str
    effects: Effects


Symbol = Constant | Storage | Local | ClockSymbol | ChannelSymbol | Alias | Function


class Scope:
    """Names of one block; a name that is not in it is looked up in the outer scope."""

    def __init__(self, outer: Scope | None = None) -> None:
        self.outer = outer
        self.symbols: dict[str, Symbol] = {}

    def declare(self, name: str, symbol: Symbol, span: Span) -> None:
        """Declare a name; raise ModelError if this block declares it already."""
        if name in self.symbols:
            raise fault(span, f"'{name}' is declared twice.")
        self.symbols[name] = symbol

    def __iter__(self) -> Iterator[str]:
        yield from self.symbols
        if self.outer:
            yield from self.outer

    def find(self, name: str) -> Symbol | None:
        """Return the innermost meaning of a name, or None."""
        scope: Scope | None = self
        while scope:
            if name in scope.symbols:
                return scope.symbols[name]
            scope = scope.outer
        return None

    def get(self, name: str, span: Span) -> Symbol:
        """Return the innermost meaning of a name.

        Raises:
            ModelError: the name is not declared.
        """
        symbol = self.find(name)
        if symbol is None:
            raise fault(span, f"'{name}' is not declared.", did_you_mean(name, self))
        return symbol
