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


def first_of_each(mutants: Sequence[Mutant], key: str) -> pytest.MarkDecorator:
    """Parametrizes ``mutant``: an ordinary run takes the first one with each value of ``key``, the night all."""
    seen: set[str] = set()
    parameters = []
    for mutant in mutants:
        marks = [pytest.mark.nightly] if mutant[key] in seen else []
        seen.add(mutant[key])
        parameters.append(pytest.param(mutant, id=f"{mutant['name']} [{mutant[key]}]", marks=marks))
    return pytest.mark.parametrize("mutant", parameters)
