"""Clock constraints and conditions: kept symbolic, so that one evaluation serves instants and zones."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

from timed_automata._text import Span

Values = Sequence[int]
Quantity = int | Callable[[Values], int]  # a number, or a function of the values
Relation = Literal["<", "<=", "==", ">=", ">"]


class Bound(NamedTuple):
    """A clock constraint in one discrete state: ``clock op value``, in the model's unit of time."""

    clock: int
    op: Relation
    value: int


@dataclass(frozen=True, slots=True, eq=False)
class ClockConstraint:
    """``clock op bound``; both sides may depend on the discrete state.

    Attributes:
        clock: its number, or a function of the values.
        bound: a number, or a function of the values.
        clocks: all that it can be about.
        low, high: between these the bound always lies.
    """

    clock: Quantity
    op: Relation
    bound: Quantity
    clocks: range
    low: int
    high: int
    span: Span

    @property
    def fixed(self) -> Bound | None:
        """The constraint, where it is the same in all states."""
        if isinstance(self.clock, int) and isinstance(self.bound, int):
            return Bound(self.clock, self.op, self.bound)
        return None

    def at(self, values: Values) -> Bound:
        """The constraint in a discrete state."""
        clock, bound = self.clock, self.bound
        return Bound(
            clock if isinstance(clock, int) else clock(values),
            self.op,
            bound if isinstance(bound, int) else bound(values),
        )


@dataclass(frozen=True, slots=True, eq=False)
class Condition:
    """A guard or an invariant: a condition on data and a conjunction of clock constraints.

    Attributes:
        data: whether the part without clocks holds; None where it always does.
        never: the part without clocks is constant and false.
        clocks: to be evaluated only where ``data`` holds.
    """

    data: Callable[[Values], Any] | None = None
    never: bool = False
    clocks: tuple[ClockConstraint, ...] = ()

    def holds(self, values: Values) -> bool:
        """Whether the part without clocks holds."""
        return not self.never and (self.data is None or bool(self.data(values)))
