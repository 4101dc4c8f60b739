"""The mutants of the file beside this one, as parameters of tests."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

Mutant = dict[str, Any]
MUTANTS: list[Mutant] = tomllib.loads(Path(__file__).with_name("mutants.toml").read_text(encoding="utf-8"))[
    "mutant"
]


def first_of_each(mutants: Sequence[Mutant], key: str, thinned: str | None = None) -> pytest.MarkDecorator:
    """Parametrizes ``mutant``: an ordinary run takes the first one with each value of ``key``, the night all.

    ``thinned``: `make test-thinned` takes the first one with each value of this other key.
    """
    seen = set[object]()
    parameters = []
    for mutant in mutants:
        if new := mutant[key] not in seen:
            marks = []
        else:
            new = thinned is not None and (thinned, mutant[thinned]) not in seen
            marks = [pytest.mark.thinned if new else pytest.mark.nightly]
        seen |= {mutant[key], (thinned, mutant.get(thinned))}
        parameters.append(pytest.param(mutant, id=f"{mutant['name']} [{mutant[key]}]", marks=marks))
    return pytest.mark.parametrize("mutant", parameters)
