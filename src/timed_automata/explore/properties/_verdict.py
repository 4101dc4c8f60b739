"""What a check says."""

from __future__ import annotations

from dataclasses import dataclass

from timed_automata.network import Trace


@dataclass(frozen=True, slots=True)
class Extreme:
    """The supremum or infimum of a clock or an integer.

    Attributes:
        value: in the model's unit of time, or the integer; None where there is none.
        attained: whether it is reached, or only approached; without a value: False means that there is no bound,
            True that the condition holds nowhere.
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
        query: as asked, on one line.
        holds: whether the property holds; for ``sup`` and ``inf``: whether there is a value for each.
        states: symbolic states that were stored.
        trace: the shortest run found that refutes (``A…``, ``-->``) or shows (``E…``, ``sup``, ``inf``) it.
        extremes: one per clock or expression of ``sup`` and ``inf``.
    """

    query: str
    holds: bool
    states: int
    trace: Trace | None = None
    extremes: tuple[Extreme, ...] = ()
