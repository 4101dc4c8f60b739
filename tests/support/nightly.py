"""How much is tried: representatives in an ordinary run, the others in ``make test-thinned``, more at night."""

from __future__ import annotations

import os
from collections.abc import Iterable

import pytest
from hypothesis import Phase

NIGHTLY = "EEHAL_NIGHTLY" in os.environ


def examples(ordinary: int, nightly: int) -> int:
    """How many, tens or thousands (``make nightly``), for hypothesis; EXPLORER_EXAMPLES says another number."""
    return int(os.environ.get("EXPLORER_EXAMPLES", nightly if NIGHTLY else ordinary))


def first_of(cases: Iterable[object], ordinary: int = 1) -> list[object]:
    """Cases that are alike, for `pytest.mark.parametrize`: an ordinary run takes the first ones."""
    return [
        pytest.param(case, marks=[] if number < ordinary else [pytest.mark.nightly])
        for number, case in enumerate(cases)
    ]


# a network that fails is small already, and shrinking it by thousands of others takes hours
PHASES = [phase for phase in Phase if not (phase is Phase.shrink and NIGHTLY)]
