"""Conditions on data, looked for in every discrete state by one expression: most never hold."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any, Generic, TypeVar

from end_effector_hal.automata import _ast as ast
from end_effector_hal.automata._network import Network, State
from end_effector_hal.automata.explore._query_terms import ARGUMENTS, QueryExpressions, QueryScope

K = TypeVar("K", bound=Hashable)


class Watch(Generic[K]):
    """Tells for each condition when it holds for the first time."""

    def __init__(self, network: Network) -> None:
        self._network = network
        self._sources: dict[K, str] = {}
        self._any: Callable[..., Any] | None = None

    def add(self, key: K, condition: ast.Expression, *, wanted: bool = True) -> None:
        """Look for a condition without clocks, or (not ``wanted``) for its contrary."""
        source = QueryExpressions(self._network.unit, QueryScope(self._network)).value(condition).source
        self._sources[key] = f"({source})" if wanted else f"(not ({source}))"
        self._any = None

    def __call__(self, state: State) -> list[K]:
        """The keys of the conditions that hold in a state and did in none before."""
        if self._any is None:
            self._any = self._compiled(" or ".join(self._sources.values()) or "False")
        if not self._any(state.values, state.locations):
            return []
        found = [key for key, s in self._sources.items() if self._compiled(s)(state.values, state.locations)]
        for key in found:
            del self._sources[key]
        self._any = None
        return found

    @property
    def open(self) -> tuple[K, ...]:
        """Those that did not hold yet."""
        return tuple(self._sources)

    def _compiled(self, source: str) -> Callable[..., Any]:
        return self._network.unit.expression(ARGUMENTS, source)
