"""Names and what they stand for."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from timed_automata.compiler._types import Type
from timed_automata.document import Span, did_you_mean, fault


@dataclass(frozen=True, slots=True)
class Constant:
    """A constant; ``values`` flat in row-major order; ``container`` names the tuple in generated code."""

    name: str
    type: Type
    values: tuple[int, ...]
    container: str


@dataclass(frozen=True, slots=True)
class Storage:
    """Scalars that stand side by side in a container of the generated code.

    A variable of the network lives in ``v`` at a fixed place; an array of a function in a list of its own; an
    array passed by reference wherever ``base`` (a Python name) says.
    """

    name: str
    type: Type
    container: str = "v"
    base: int | str = 0
    written: bool = True  # whether assignments are allowed

    @property
    def shared(self) -> bool:
        """A variable of the network, not of a function."""
        return self.container == "v" and isinstance(self.base, int)


@dataclass(frozen=True, slots=True)
class Local:
    """A scalar of a function, a quantifier or a loop: a Python name."""

    name: str
    type: Type
    python: str
    written: bool = True


@dataclass(frozen=True, slots=True)
class ClockSymbol:
    """A clock or an array of clocks, by the index of the first."""

    name: str
    type: Type
    base: int


@dataclass(frozen=True, slots=True)
class ChannelSymbol:
    """A channel or an array of channels, by the index of the first."""

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
    """What code touches, by the names of variables and clocks of the network."""

    reads: set[str] = field(default_factory=set)
    writes: set[str] = field(default_factory=set)
    repeats: int = 1
    """How often its innermost part is evaluated: what quantifiers and loops within each other run through."""

    def add(self, other: Effects) -> None:
        """Add what another touches."""
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
    """A function, by its name in generated code, with what it touches of the network."""

    name: str
    parameters: tuple[FormalParameter, ...]
    result: Type
    python: str
    effects: Effects


Symbol = Constant | Storage | Local | ClockSymbol | ChannelSymbol | Alias | Function


class Scope:
    """Names of one block; unknown ones are looked for outside."""

    def __init__(self, outer: Scope | None = None) -> None:
        self.outer = outer
        self.symbols: dict[str, Symbol] = {}

    def declare(self, name: str, symbol: Symbol, span: Span) -> None:
        """Give a meaning to a name that has none yet in this block."""
        if name in self.symbols:
            raise fault(span, f"'{name}' is declared twice.")
        self.symbols[name] = symbol

    def __iter__(self) -> Iterator[str]:
        yield from self.symbols
        if self.outer:
            yield from self.outer

    def find(self, name: str) -> Symbol | None:
        """The innermost meaning, or None."""
        scope: Scope | None = self
        while scope:
            if name in scope.symbols:
                return scope.symbols[name]
            scope = scope.outer
        return None

    def get(self, name: str, span: Span) -> Symbol:
        """The innermost meaning.

        Raises:
            ModelError: there is none.
        """
        symbol = self.find(name)
        if symbol is None:
            raise fault(span, f"'{name}' is not declared.", did_you_mean(name, self))
        return symbol
