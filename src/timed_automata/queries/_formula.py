"""Conditions of queries: conditions on data are compiled to code, those on clocks stay symbolic.

In a discrete state a condition is a disjunction of cases; every case is a conjunction of clock constraints, so the
condition is a union of zones.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass
from itertools import compress
from typing import Any, Generic, NamedTuple, TypeVar

from timed_automata.compiler import Bound, ClockConstraint
from timed_automata.network import Network, State

K = TypeVar("K", bound=Hashable)
ARGUMENTS = "v, l, r=None"  # of compiled conditions: values, locations


class Case(NamedTuple):
    """A conjunction of clock constraints; ``deadlock`` requires a deadlock or its absence (None: neither)."""

    bounds: tuple[Bound, ...] = ()
    deadlock: bool | None = None


TRUE = Case()


@dataclass(frozen=True, slots=True)
class Data:
    """A condition without clocks."""

    holds: Callable[[tuple[int, ...], tuple[int, ...]], Any]
    source: str
    wanted: bool = True
    known: bool | None = None  # what constants make of it

    def cases(self, state: State) -> list[Case]:
        """Return the case without constraints if the condition holds, else nothing."""
        return [TRUE] if bool(self.holds(state.values, state.locations)) is self.wanted else []


@dataclass(frozen=True, slots=True)
class Comparison:
    """The comparison of a clock with a number."""

    constraint: ClockConstraint

    def cases(self, state: State) -> list[Case]:
        """Return one case with one constraint."""
        return [Case((self.constraint.at(state.values, state.locations),))]


@dataclass(frozen=True, slots=True)
class Deadlock:
    """The word ``deadlock`` in a query."""

    wanted: bool

    def cases(self, state: State) -> list[Case]:
        """Return one case that the search decides."""
        return [Case((), self.wanted)]


@dataclass(frozen=True, slots=True)
class All:
    """A conjunction; parts after a false one are not evaluated."""

    parts: tuple[Formula, ...]

    def cases(self, state: State) -> list[Case]:
        """Return the product of the cases of the parts."""
        cases = [TRUE]
        for part in self.parts:
            if isinstance(part, Data):
                if bool(part.holds(state.values, state.locations)) is not part.wanted:
                    return []
                continue
            more = part.cases(state)
            cases = [
                joined for left in cases for right in more if (joined := _joined(left, right)) is not None
            ]
            if not cases:
                break
        return cases


@dataclass(frozen=True, slots=True)
class Some:
    """A disjunction; parts after a true one are not evaluated."""

    parts: tuple[Formula, ...]

    def cases(self, state: State) -> list[Case]:
        """Return the cases of all parts."""
        found: list[Case] = []
        for part in self.parts:
            cases = part.cases(state)
            if TRUE in cases:
                return [TRUE]
            found += cases
        return found


Formula = Data | Comparison | Deadlock | All | Some


def _joined(left: Case, right: Case) -> Case | None:
    if left.deadlock is not None and right.deadlock is not None and left.deadlock != right.deadlock:
        return None
    deadlock = left.deadlock if right.deadlock is None else right.deadlock
    return Case(left.bounds + right.bounds, deadlock)


def mentions_deadlock(formula: Formula) -> bool:
    """Return whether a formula contains the word ``deadlock``."""
    if isinstance(formula, All | Some):
        return any(map(mentions_deadlock, formula.parts))
    return isinstance(formula, Deadlock)


class ConditionFilter(Generic[K]):
    """Finds the conditions that can hold in a discrete state for some values of the clocks.

    It evaluates one expression for all of them first, because in most states none can hold, then one for each.
    """

    def __init__(self, network: Network, conditions: Mapping[K, Formula]) -> None:
        self._keys = tuple(conditions)
        parts = [_possible(formula) for formula in conditions.values()]
        self._any = network.code.expression(ARGUMENTS, " or ".join(parts) or "False")
        self._each = network.code.expression(ARGUMENTS, f"({' '.join(f'{part},' for part in parts)})")

    def __call__(self, state: State) -> tuple[K, ...]:
        """Return the keys of the conditions that can hold."""
        locations, values = state
        if not self._any(values, locations):
            return ()
        return tuple(compress(self._keys, self._each(values, locations)))


def _possible(formula: Formula) -> str:
    """Return the code of an expression that is true if the formula has cases for some values of the clocks."""
    if isinstance(formula, Data):
        return f"({formula.source})" if formula.wanted else f"(not ({formula.source}))"
    if isinstance(formula, All | Some):
        word = " and " if isinstance(formula, All) else " or "
        return f"({word.join(map(_possible, formula.parts))})" if formula.parts else str(word == " and ")
    return "True"
