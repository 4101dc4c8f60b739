"""The requirement that a list names notices each mutant of the shipped automata."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from end_effector_hal.verification.lemmas import COILS_FILE
from end_effector_hal.verification.proof import requirements_of
from tests.unit.verification.mutants.conftest import MUTANTS, REACTION, Mutant, Shipped, first_of_each
from timed_automata.explore import overview


@pytest.mark.thinned
@first_of_each(MUTANTS, "caught_by")
def test_the_mutant_is_caught(mutant, shipped):
    assert shipped.catches(mutant), f"{mutant['name']}: survives"


@pytest.mark.thinned
@pytest.mark.parametrize(
    "mutant", [each for each in MUTANTS if "forgets" in each], ids=lambda each: each["name"]
)
def test_the_line_arbiter_alone_keeps_what_the_program_forgets(mutant, shipped):
    query = {each.id: each.query for each in requirements_of(shipped.network())}[mutant["caught_by"]]
    assert overview(shipped.original(mutant), [query]).answers[0]


@pytest.mark.thinned
def test_the_shipped_automata_are_none(shipped):
    network = shipped.network()
    requirements = requirements_of(network)
    found = overview(network, [requirement.query for requirement in requirements], reaction=REACTION)
    assert [r.id for r, holds in zip(requirements, found.answers, strict=True) if not holds] == []
    assert shipped.failing_checks(found) == []
    assert not found.unmet


@pytest.mark.thinned
def test_there_are_enough_and_each_is_another():
    assert len(MUTANTS) >= 25
    edits = [{key: mutant[key] for key in mutant if key not in ("name", "caught_by")} for mutant in MUTANTS]
    assert all(edits.count(edit) == 1 for edit in edits)
    assert len({mutant["name"] for mutant in MUTANTS}) == len(MUTANTS)


# The requirement that a list names notices each mutant of the network of two coils.


TWO_COILS: list[Mutant] = tomllib.loads(
    Path(__file__).with_name("two_coils.toml").read_text(encoding="utf-8")
)["mutant"]


@pytest.fixture(scope="module")
def coils() -> Shipped:
    return Shipped(COILS_FILE.read_text(encoding="utf-8"), {"PULSE": 100})


@first_of_each(TWO_COILS, "template", thinned="caught_by")
def test_the_mutant_of_two_coils_is_caught(mutant: Mutant, coils: Shipped) -> None:
    assert coils.catches(mutant), f"{mutant['name']}: survives"
