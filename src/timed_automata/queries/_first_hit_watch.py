"""Conditions on data, looked for in every discrete state by one expression: most never hold."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from itertools import compress
from typing import Any, Generic, TypeVar

from timed_automata.language import ast
from timed_automata.network import Network, State
from timed_automata.queries._query_names import ARGUMENTS, QueryExpressions, QueryScope

K = TypeVar("K", bound=Hashable)


_ENOUGH = 20  # states in which only what is known holds: then compiling again without it pays


class FirstHitWatch(Generic[K]):
    """Tells for each condition when it holds for the first time."""

    def __init__(self, network: Network) -> None:
        self._network = network
        self._sources: dict[K, str] = {}
        self._open: dict[K, str] = {}
        self._any: Callable[..., Any] | None = None
        self._each: Callable[..., Any] = lambda *_: ()
        self._idle = 0

    def add(self, key: K, condition: ast.Expression, *, wanted: bool = True) -> None:
        """Look for a condition without clocks, or (not ``wanted``) for its contrary."""
        source = QueryExpressions(self._network.code, QueryScope(self._network)).value(condition).source
        self._sources[key] = self._open[key] = f"({source})" if wanted else f"(not ({source}))"
        self._any = None

    def __call__(self, state: State) -> list[K]:
        """The keys of the conditions that hold in a state and did in none before."""
        locations, values = state
        if self._any is None:
            self._each = self._compiled(f"({' '.join(f'{source},' for source in self._sources.values())})")
            self._any = self._compiled(" or ".join(self._open.values()) or "False")
        if not self._any(values, locations):
            return []
        holding = compress(self._sources, self._each(values, locations))
        found = [key for key in holding if self._open.pop(key, None) is not None]
        self._idle += not found
        if self._idle >= _ENOUGH:
            self._any, self._idle = None, 0
        return found

    @property
    def open(self) -> tuple[K, ...]:
        """Those that did not hold yet."""
        return tuple(self._open)

    def _compiled(self, source: str) -> Callable[..., Any]:
        return self._network.code.expression(ARGUMENTS, source)
