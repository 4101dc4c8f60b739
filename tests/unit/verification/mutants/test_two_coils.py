"""Each mutant of the network of two coils is found out by a requirement that is named beforehand."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from end_effector_hal.verification.lemmas import COILS_FILE
from tests.unit.verification.mutants.conftest import Shipped
from tests.unit.verification.mutants.mutants import Mutant, first_of_each

MUTANTS: list[Mutant] = tomllib.loads(Path(__file__).with_name("two_coils.toml").read_text(encoding="utf-8"))[
    "mutant"
]


@pytest.fixture(scope="module")
def coils() -> Shipped:
    return Shipped(COILS_FILE.read_text(encoding="utf-8"), {"PULSE": 100})


@first_of_each(MUTANTS, "template", thinned="caught_by")
def test_the_mutant_is_caught(mutant: Mutant, coils: Shipped) -> None:
    assert coils.catches(mutant), f"{mutant['name']}: survives"
