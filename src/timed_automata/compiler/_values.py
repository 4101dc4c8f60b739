"""The terms to which expressions are compiled, and the operators on values.

A value has Python source, an interval, and its number if that is known. Run-time checks that the interval proves
unnecessary are left out.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from operator import eq, ge, gt, le, lt, ne

from timed_automata.compiler._scope import Storage
from timed_automata.compiler._types import Type

WIDE = 2**31  # what UPPAAL computes with


@dataclass(frozen=True, slots=True)
class Value:
    """An integer expression: its Python source and the interval of its value."""

    source: str
    low: int = -WIDE
    high: int = WIDE - 1
    truth: bool = False  # only whether it is zero is meaningful: a Python bool, or any operand of and/or
    known: int | None = None

    @classmethod
    def of(cls, number: int) -> Value:
        """Return a constant value."""
        return cls(str(number) if number >= 0 else f"({number})", number, number, known=number)

    @property
    def integer(self) -> Value:
        """The value as a number; true is 1 and false is 0."""
        return Value(f"(1 if {self.source} else 0)", 0, 1) if self.truth else self

    @property
    def boolean(self) -> Value:
        """The truth of the value as a number: 0 or 1."""
        if self.known is not None:
            return Value.of(int(self.known != 0))
        return (
            self
            if not self.truth and self.low >= 0 and self.high <= 1
            else Value(self.source, truth=True).integer
        )

    def within(self, low: int, high: int) -> bool:
        """Return whether the value always lies between ``low`` and ``high``."""
        return low <= self.low and self.high <= high


@dataclass(frozen=True, slots=True)
class StorageTerm:
    """A scalar or an array in a container: a fixed offset plus a computed one (Python source, may be empty)."""

    storage: Storage
    type: Type
    offset: int = 0
    computed: str = ""
    values: tuple[int, ...] | None = None  # of a constant

    @property
    def start(self) -> str:
        """Source of the index of the first scalar."""
        base = self.storage.base
        parts = [base] if isinstance(base, str) else []
        fixed = self.offset + (base if isinstance(base, int) else 0)
        if fixed or not (parts or self.computed):
            parts.append(str(fixed))
        return " + ".join([*parts, self.computed] if self.computed else parts)

    @property
    def known(self) -> tuple[int, ...] | None:
        """The values of a constant, if they do not depend on the state."""
        if self.values is None or self.computed:
            return None
        return self.values[self.offset : self.offset + self.type.size]

    @property
    def source(self) -> str:
        """Source of the scalar."""
        return f"{self.storage.container}[{self.start}]"

    @property
    def slice(self) -> str:
        """Source of all scalars of the array, as a list."""
        start = self.start
        end = f"{start} + {self.type.size}" if not start.isdigit() else str(int(start) + self.type.size)
        return f"[*{self.storage.container}[{start}:{end}]]"


@dataclass(frozen=True, slots=True)
class IndexedTerm:
    """A clock or a channel: the number of the first in its array of ``size``, plus a fixed and a computed offset."""

    name: str
    type: Type
    base: int
    offset: int = 0
    computed: str = ""
    size: int = 1

    @property
    def possible(self) -> range:
        """All numbers that the clock or channel can have."""
        first = self.base + self.offset
        return range(self.base, self.base + self.size) if self.computed else range(first, first + 1)

    @property
    def source(self) -> str:
        """Source of the number of the clock or channel."""
        return (
            f"{self.base + self.offset} + {self.computed}" if self.computed else str(self.base + self.offset)
        )


Term = Value | StorageTerm | IndexedTerm


COMPARISONS: dict[str, Callable[[int, int], bool]] = {
    "==": eq,
    "!=": ne,
    "<": lt,
    "<=": le,
    ">": gt,
    ">=": ge,
}


def negation(operand: Value) -> Value:
    """Return ``!a``."""
    if operand.known is not None:
        return Value.of(int(not operand.known))
    return Value(f"(not {operand.source})", 0, 1, truth=True)


def signed(op: str, operand: Value) -> Value:
    """Return ``-a`` or ``+a``."""
    number = operand.integer
    if op == "+":
        return number
    if number.known is not None:
        return Value.of(-number.known)
    return Value(f"(-{number.source})", -number.high, -number.low)


def logical(op: str, left: Value, right: Value) -> Value:
    """Return ``a && b``, ``a || b`` or ``a imply b``; the right operand is not evaluated if the left one decides."""
    if op == "imply":
        left = negation(left)
    decisive = op != "&&"  # the truth of an operand that decides the whole
    if left.known is not None:
        return Value.of(int(decisive)) if bool(left.known) == decisive else right.boolean
    if right.known is not None and bool(right.known) != decisive:
        return left.boolean
    word = "or" if decisive else "and"
    return Value(f"({left.source} {word} {right.source})", 0, 1, truth=True)


def comparison(op: str, left: Value, right: Value) -> Value:
    """Return a comparison: ``a == b``, ``a < b``, …"""
    a, b = left.integer, right.integer
    if a.known is not None and b.known is not None:
        return Value.of(int(COMPARISONS[op](a.known, b.known)))
    return Value(f"({a.source} {op} {b.source})", 0, 1, truth=True)


def conditional(test: Value, yes: Value, no: Value) -> Value:
    """Return ``test ? yes : no``."""
    yes, no = yes.integer, no.integer
    if test.known is not None:
        return yes if test.known else no
    source = f"({yes.source} if {test.source} else {no.source})"
    return Value(source, min(yes.low, no.low), max(yes.high, no.high))


def interval(op: str, left: Value, right: Value) -> tuple[int, int]:
    """Return the interval of the result of an arithmetic operation."""
    if op == "+":
        return left.low + right.low, left.high + right.high
    if op == "-":
        return left.low - right.high, left.high - right.low
    if op == "*":
        corners = [a * b for a in (left.low, left.high) for b in (right.low, right.high)]
        return min(corners), max(corners)
    if op == "<?":
        return min(left.low, right.low), min(left.high, right.high)
    if op == ">?":
        return max(left.low, right.low), max(left.high, right.high)
    if op == "/":
        most = max(abs(left.low), abs(left.high))
        return (0 if left.low >= 0 and right.low >= 0 else -most), most
    if op == "%":
        most = max(abs(right.low), abs(right.high)) - 1
        return (0 if left.low >= 0 else -most), most
    if op in ("&", "|", "^") and left.low >= 0 and right.low >= 0:
        return 0, (1 << max(left.high, right.high).bit_length()) - 1
    return -WIDE, WIDE - 1


def arithmetic(op: str, left: Value, right: Value, site: Callable[[], int]) -> Value:
    """Return an arithmetic operation; ``site`` is called for a place only if the operation can fail."""
    left, right = left.integer, right.integer
    low, high = interval(op, left, right)
    a, b = left.source, right.source
    if op in ("+", "-", "*", "&", "|", "^"):
        source = f"({a} {op} {b})"
    elif op in ("<?", ">?"):
        source = f"{'min' if op == '<?' else 'max'}({a}, {b})"
    elif op in ("/", "%") and left.low >= 0 and right.low > 0:
        source = f"({a} {'//' if op == '/' else '%'} {b})"
    else:
        name = {"/": "_div", "%": "_mod", "<<": "_shl", ">>": "_shr"}[op]
        source = f"{name}({a}, {b}, {site()})"
    return Value(source, low, high)
