"""A mistake that somebody could make in the product, and what finds it."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import pytest

Patch = Callable[[pytest.MonkeyPatch], None]


class WrongProduct(NamedTuple):
    """A mutant.

    Attributes:
        patch: makes the mistake.
        place: of the mistake: a file below ``src/end_effector_hal``, and a name in it.
        found_by: the smallest case that finds it, in words; or the id of a cell of the matrix.
        rule: the rule that objects, by its name.
        cell: of the matrix that finds it as well; empty: none does, or nobody has looked for one.
    """

    patch: Patch
    place: str
    found_by: str
    rule: str
    cell: str = ""

    @property
    def is_cell(self) -> bool:
        """Whether a cell finds it, and no case."""
        return " @ " in self.found_by
