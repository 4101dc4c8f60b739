"""The results of a check: a verdict, and extremes."""

from __future__ import annotations

from dataclasses import dataclass

from timed_automata.network import Trace


@dataclass(frozen=True, slots=True)
class Extreme:
    """The supremum or infimum of a clock or an integer.

    Attributes:
        value: the extreme, for a clock in the model's unit of time; None if there is none.
        attained: whether the value is reached, or only approached; without a value, False means that there is no
            bound, True that the condition holds nowhere.
    """

    value: int | None
    attained: bool

    def __str__(self) -> str:
        if self.value is None:
            return "unbounded" if not self.attained else "never"
        return str(self.value) if self.attained else f"{self.value} (not reached)"


@dataclass(frozen=True, slots=True)
class Verdict:
    """The answer to a query.

    Attributes:
        query: the query, on one line.
        holds: whether the property holds; for ``sup`` and ``inf``: whether all targets have a value.
        states: number of symbolic states that were stored.
        trace: the shortest run found that refutes (``A…``, ``-->``) or shows (``E…``, ``sup``, ``inf``) it.
        extremes: one value per clock or expression of ``sup`` and ``inf``.
    """

    query: str
    holds: bool
    states: int
    trace: Trace | None = None
    extremes: tuple[Extreme, ...] = ()
