"""The generated Python code of a network, and the functions that it calls at run time.

A checker evaluates guards millions of times: compiled Python is several times faster than walking a tree. No text of
the file reaches the compiler, only numbers and generated names rebuilt from the checked syntax tree.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from types import CodeType
from typing import Any, NoReturn

from timed_automata.document import Span
from timed_automata.errors import RangeError

LOOP_LIMIT = 100_000  # iterations of one loop of a function: more is taken for endless


def divide(left: int, right: int) -> int:
    """Return the quotient as C does, rounded towards zero."""
    quotient = abs(left) // abs(right)
    return quotient if (left < 0) == (right < 0) else -quotient


def remainder(left: int, right: int) -> int:
    """Return the remainder as C does, with the sign of the dividend."""
    return left - right * divide(left, right)


@lru_cache(maxsize=4000)
def _compiled(code: str, mode: str) -> CodeType:
    """Compile code once: networks that differ in one edge or one constant share nearly all of their code."""
    return compile(code, "<network>", mode)


class GeneratedCode:
    """Collects generated code; ``sites`` are the places in the model that run-time errors refer to."""

    def __init__(self) -> None:
        self._sites: list[tuple[Span, str]] = []
        self._cache: dict[str, Callable[..., Any]] = {}
        self._count = 0
        self.formulas: dict[object, Any] = {}
        """Compiled formulas of queries, shared by all networks that have this code."""
        self.elements = 0
        """Number of scalars and array elements declared so far."""
        self.parts = 0
        """Number of locations and edges made so far."""
        called = ("_set", "_range", "_index", "_div", "_mod", "_shl", "_shr", "_endless", "_missing")
        builtins = {each.__name__: each for each in (all, any, enumerate, max, min, range, sum)}
        self.names: dict[str, Any] = {name: getattr(self, name) for name in called}
        self.names["__builtins__"] = builtins

    def name(self, prefix: str) -> str:
        """Return a Python name that is not used elsewhere."""
        self._count += 1
        return f"{prefix}{self._count}"

    def site(self, span: Span, what: str) -> int:
        """Return the number by which generated code refers to a place in the model."""
        self._sites.append((span, what))
        return len(self._sites) - 1

    def constant(self, values: tuple[int, ...]) -> str:
        """Store a tuple that generated code can index, and return its name."""
        name = self.name("K")
        self.names[name] = values
        return name

    def expression(self, arguments: str, source: str) -> Callable[..., Any]:
        """Return a function of one expression; equal code gives the same function."""
        code = f"lambda {arguments}: {source}"
        if code not in self._cache:
            self._cache[code] = eval(_compiled(code, "eval"), self.names)  # noqa: S307 - see module
        return self._cache[code]

    def function(self, name: str, arguments: str, lines: list[str]) -> Callable[..., Any]:
        """Define a function from statements; all code generated afterwards can call it by its name."""
        code = "\n".join([f"def {name}({arguments}):", *(f" {line}" for line in lines or ["pass"])])
        exec(_compiled(code, "exec"), self.names)  # noqa: S102 - see module
        function: Callable[..., Any] = self.names[name]
        return function

    def procedure(self, arguments: str, lines: list[str]) -> Callable[..., Any]:
        """Return a function of statements that is not called by name; equal code gives the same function."""
        code = arguments + "\n" + "\n".join(lines)
        if code not in self._cache:
            self._cache[code] = self.function(self.name("u"), arguments, lines)
        return self._cache[code]

    # Called by generated code

    def _fail(self, site: int, what: str) -> NoReturn:
        span, name = self._sites[site]
        raise RangeError(what.format(name), where=span.where)

    @staticmethod
    def _set(container: Any, at: int, value: int) -> int:
        container[at] = value
        return value

    def _range(self, value: int, low: int, high: int, site: int) -> int:
        if not low <= value <= high:
            self._fail(site, f"{{}} = {value} is out of its range [{low},{high}].")
        return value

    def _index(self, value: int, low: int, high: int, site: int) -> int:
        if not low <= value <= high:
            self._fail(site, f"Index {value} of {{}} is outside of {low} to {high}.")
        return value

    def _div(self, left: int, right: int, site: int) -> int:
        return divide(left, right) if right else self._fail(site, "Division by zero in {}.")

    def _mod(self, left: int, right: int, site: int) -> int:
        return remainder(left, right) if right else self._fail(site, "Division by zero in {}.")

    def _shl(self, left: int, right: int, site: int) -> int:
        return left << right if 0 <= right < 32 else self._fail(site, f"Shift by {right} in {{}}.")

    def _shr(self, left: int, right: int, site: int) -> int:
        return left >> right if 0 <= right < 32 else self._fail(site, f"Shift by {right} in {{}}.")

    def _endless(self, site: int) -> NoReturn:
        self._fail(site, f"This loop does not end within {LOOP_LIMIT} rounds: {{}}.")

    def _missing(self, site: int) -> NoReturn:
        self._fail(site, "{} ends without a value: a 'return' is missing.")
