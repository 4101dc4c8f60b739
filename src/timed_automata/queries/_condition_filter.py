"""Where conditions of queries can hold at all, whatever the clocks say: one expression for each discrete state."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import compress

from timed_automata.network import Network, State
from timed_automata.queries._formula import All, Data, Formula, Some
from timed_automata.queries._query_names import ARGUMENTS


class ConditionFilter:
    """Tells which of some numbered conditions can hold in a discrete state."""

    def __init__(self, network: Network, conditions: Mapping[int, Formula]) -> None:
        self._numbers = tuple(conditions)
        parts = [_possible(formula) for formula in conditions.values()]
        self._any = network.code.expression(ARGUMENTS, " or ".join(parts) or "False")
        self._each = network.code.expression(ARGUMENTS, f"({' '.join(f'{part},' for part in parts)})")

    def __call__(self, state: State) -> tuple[int, ...]:
        """The numbers of those that can."""
        locations, values = state
        if not self._any(values, locations):
            return ()
        return tuple(compress(self._numbers, self._each(values, locations)))


def _possible(formula: Formula) -> str:
    """Code of an expression that is true wherever the formula has cases, whatever the clocks say."""
    if isinstance(formula, Data):
        return f"({formula.source})" if formula.wanted else f"(not ({formula.source}))"
    if isinstance(formula, All | Some):
        word = " and " if isinstance(formula, All) else " or "
        return f"({word.join(map(_possible, formula.parts))})" if formula.parts else str(word == " and ")
    return "True"
