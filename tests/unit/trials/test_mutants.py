"""The product with one mistake each: what is said to find it does, and has nothing against the product."""

from __future__ import annotations

from collections.abc import Collection
from functools import cache
from pathlib import Path

import pytest

import end_effector_hal
from end_effector_hal.description import load, profile_path
from end_effector_lab.trials import (
    Cell,
    case_from_words,
    cells_of,
    kind_of_failure,
    moments,
    play,
    play_case,
    read_failures,
    run_campaign,
)
from end_effector_lab.workers import LocalWorkers
from tests.support.nightly import NIGHTLY, first_of
from tests.unit.trials.mutants import ARBITER, CONTROLLER, MUTANTS
from tests.unit.trials.mutants.by_chance import recorded

pytestmark = pytest.mark.thinned  # long

SHIPPED = load(profile_path())
LONGEST = 150


@cache
def cells() -> dict[str, Cell]:
    return {cell.id: cell for cell in cells_of(SHIPPED, moments(SHIPPED))}


def objections(found_by: str, seed: int = 0) -> Collection[str]:
    """Rules that a case breaks, or what is said against a cell."""
    if " @ " in found_by:
        return play(SHIPPED, cells()[found_by]).objections
    return play_case(SHIPPED, case_from_words(found_by, SHIPPED, seed=seed)).failures


def first_of_each_file() -> list[object]:
    """Each mutant by its name; CI takes one of each file of the product."""
    seen, found = set[str](), list[object]()
    for name, mutant in MUTANTS.items():
        file = mutant.place.partition(":")[0]
        found.append(pytest.param(name, marks=[pytest.mark.nightly] if file in seen else []))
        seen.add(file)
    return found


@pytest.mark.parametrize("name", first_of_each_file())
def test_a_mutant_is_found(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    mutant = MUTANTS[name]
    ways = [mutant.found_by, *([mutant.cell] if mutant.cell else [])]
    assert not any(map(objections, ways))
    mutant.patch(monkeypatch)
    assert any(mutant.rule in each for each in objections(mutant.found_by))
    assert all(map(objections, ways))


def test_there_are_enough_and_all_are_in_the_product() -> None:
    assert len(CONTROLLER) >= 20
    assert len(ARBITER) >= 10
    assert len(MUTANTS) == len(CONTROLLER) + len(ARBITER)
    product = Path(end_effector_hal.__file__).parent
    for mutant in MUTANTS.values():
        file, _, name = mutant.place.partition(": ")
        if file != "the UPPAAL file":
            assert name.rpartition(".")[2] in (product / file).read_text(encoding="utf-8"), mutant.place


BY_CHANCE = {name: chance.run for name, chance in recorded().items() if chance.run is not None}


def test_the_record_is_of_these_wrong_products() -> None:
    assert recorded().keys() <= MUTANTS.keys()
    assert len(BY_CHANCE) >= 10


@pytest.mark.parametrize("name", first_of(sorted(BY_CHANCE, key=lambda name: BY_CHANCE[name]), thinned=0))
def test_a_campaign_finds_a_mutant_and_shrinks_it(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    MUTANTS[name].patch(monkeypatch)
    most = LONGEST if NIGHTLY else BY_CHANCE[name] + 1
    campaign = run_campaign(
        SHIPPED,
        tmp_path,
        LocalWorkers(1),
        seed=0,
        go_on=lambda so_far, run: run < most and not so_far.failures,
    )
    assert campaign.failures
    smallest = read_failures(tmp_path / "failures")[0]
    assert len(smallest["happenings"]) <= 5
    case = case_from_words(smallest["words"], SHIPPED, seed=smallest["seed"])
    failures = play_case(SHIPPED, case).failures.values()
    assert smallest["kind"] in map(kind_of_failure, failures)
