"""How much is tried: representatives in an ordinary run, some more in ``make test-thinned``, all at night."""

from __future__ import annotations

import os
from collections.abc import Iterable

import pytest
from hypothesis import Phase

NIGHTLY = "EEHAL_NIGHTLY" in os.environ


def examples(ordinary: int, nightly: int) -> int:
    """How many, tens or thousands (``make nightly``), for hypothesis; EXPLORER_EXAMPLES says another number."""
    return int(os.environ.get("EXPLORER_EXAMPLES", nightly if NIGHTLY else ordinary))


def first_of(cases: Iterable[object], ordinary: int = 1, thinned: int | None = None) -> list[object]:
    """Cases that are alike, for `pytest.mark.parametrize`: `make test` takes the first ones.

    ``thinned``: how many of the others `make test-thinned` takes (None: all); what is left is for `make nightly`.
    """
    until = None if thinned is None else ordinary + thinned
    return [pytest.param(case, marks=mark_of(number, ordinary, until)) for number, case in enumerate(cases)]


def mark_of(number: int, ordinary: int, until: int | None) -> tuple[pytest.MarkDecorator, ...]:
    """When a case is tried: in each run below ``ordinary``, in CI below ``until``, else at night."""
    if number < ordinary:
        return ()
    return (pytest.mark.thinned if until is None or number < until else pytest.mark.nightly,)


# a network that fails is small already, and shrinking it by thousands of others takes hours
PHASES = [phase for phase in Phase if not (phase is Phase.shrink and NIGHTLY)]
