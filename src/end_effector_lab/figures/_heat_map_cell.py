"""A cell of a grid of numbers; without matplotlib, for what fills the grid."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class HeatMapCell:
    """A number, and why it does not hold.

    Attributes:
        value: None: there is none.
        wrong: in a word; empty: it holds.
    """

    value: float | None
    wrong: str = ""
