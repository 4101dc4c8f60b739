"""Conditions of queries: over data they are code, over clocks they stay symbolic.

In a discrete state a condition is a disjunction of cases, each a conjunction of clock constraints: a union of zones.
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
    """A conjunction: clock constraints, and whether the state must (not) be deadlocked (None: no matter)."""

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
        """True or nothing."""
        return [TRUE] if bool(self.holds(state.values, state.locations)) is self.wanted else []


@dataclass(frozen=True, slots=True)
class Comparison:
    """A clock against a number."""

    constraint: ClockConstraint

    def cases(self, state: State) -> list[Case]:
        """One constraint."""
        return [Case((self.constraint.at(state.values, state.locations),))]


@dataclass(frozen=True, slots=True)
class Deadlock:
    """The word ``deadlock``."""

    wanted: bool

    def cases(self, state: State) -> list[Case]:
        """One case, left to the search."""
        return [Case((), self.wanted)]


@dataclass(frozen=True, slots=True)
class All:
    """A conjunction; what follows a part that is false is not evaluated."""

    parts: tuple[Formula, ...]

    def cases(self, state: State) -> list[Case]:
        """The product of the cases of the parts."""
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
    """A disjunction; what follows a part that is true is not evaluated."""

    parts: tuple[Formula, ...]

    def cases(self, state: State) -> list[Case]:
        """The cases of all parts."""
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
    """Whether a formula asks for deadlocks."""
    if isinstance(formula, All | Some):
        return any(map(mentions_deadlock, formula.parts))
    return isinstance(formula, Deadlock)


class ConditionFilter(Generic[K]):
    """Tells which of some conditions can hold in a discrete state, whatever the clocks say.

    One expression for all of them, as in most states none can; one for each of them.
    """

    def __init__(self, network: Network, conditions: Mapping[K, Formula]) -> None:
        self._keys = tuple(conditions)
        parts = [_possible(formula) for formula in conditions.values()]
        self._any = network.code.expression(ARGUMENTS, " or ".join(parts) or "False")
        self._each = network.code.expression(ARGUMENTS, f"({' '.join(f'{part},' for part in parts)})")

    def __call__(self, state: State) -> tuple[K, ...]:
        """The keys of those that can."""
        locations, values = state
        if not self._any(values, locations):
            return ()
        return tuple(compress(self._keys, self._each(values, locations)))


def _possible(formula: Formula) -> str:
    """Code of an expression that is true wherever the formula has cases, whatever the clocks say."""
    if isinstance(formula, Data):
        return f"({formula.source})" if formula.wanted else f"(not ({formula.source}))"
    if isinstance(formula, All | Some):
        word = " and " if isinstance(formula, All) else " or "
        return f"({word.join(map(_possible, formula.parts))})" if formula.parts else str(word == " and ")
    return "True"
