"""Readings need no memory: with sensors that are free all requirements hold but that time diverges."""

from __future__ import annotations

from collections.abc import Mapping

import pytest

from end_effector_hal.control import model_constants
from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import UsageError
from end_effector_hal.verification.proof import free_constants, prove, requirements_of
from tests.support.nightly import NIGHTLY, first_of
from tests.unit.verification.mutants.conftest import MUTANTS, Mutant, Shipped, first_of_each
from timed_automata import Network, make_network, read_document
from timed_automata.explore import Overview, overview

pytestmark = pytest.mark.thinned  # long

AFTER_A_REFUSAL = " || refusing == GRIP"


def text() -> str:
    return load(profile_path()).automata_path.read_text(encoding="utf-8")


def sized(count: int, **others: object) -> dict[str, object]:
    """The constants of the shipped tool with as many steps, each like one of its own, and bounds that fit."""
    constants = model_constants(load(profile_path()))
    steps = {
        name: [(row * 2)[:count] for row in each] if isinstance(each[0], list) else (each * 2)[:count]
        for name, each in constants.items()
        if isinstance(each, list)
    }
    attempt_ms = 3 * 5050 + 2 * 1050
    bounds = {
        "GRIP_BOUND": count * (attempt_ms + 2050),
        "RELEASE_BOUND": count * 2050,
        "CANCEL_BOUND": count * 2050,
    }
    order = {"N": count, "RELEASE_ORDER": list(range(count))[::-1]}
    return constants | steps | order | bounds | others


def network(source: str, constants: Mapping[str, object], which: str | None = "actuators") -> Network:
    document = read_document(source.encode(), "tool.xml")
    free = free_constants(make_network(document, dict(constants)), which) if which else {}  # type: ignore[arg-type]
    return make_network(document, {**constants, **free})  # type: ignore[dict-item]


def explored(network: Network) -> tuple[Overview, list[str]]:
    """What one exploration says, and which requirements do not hold there."""
    requirements = requirements_of(network)
    found = overview(network, [each.query for each in requirements])
    return found, [each.id for each, holds in zip(requirements, found.answers, strict=True) if not holds]


@pytest.mark.timeout(3600)
@pytest.mark.parametrize(
    ("count", "which"),
    [
        (2, "actuators"),
        pytest.param(3, "actuators", marks=pytest.mark.nightly),
        (1, "all"),
        *([(4, "actuators"), (2, "all")] if NIGHTLY else []),
    ],
)
def test_all_holds_with_free_sensors_but_that_time_diverges(count: int, which: str) -> None:
    found, failing = explored(network(text(), sized(count), which))
    assert failing == []
    if count > 1:  # with one step some of the edges and premises need another one
        assert (found.unmet, found.coverage.locations, found.coverage.edges) == (frozenset(), (), ())
    assert not found.open_channels
    assert not found.stuck
    # a sensor that has no least time between two changes flickers for ever at one instant: such a run never ends
    assert found.zeno


OTHERS: Mapping[str, Mapping[str, object]] = {
    "with evidence of nothing": {"SHOWS_EMPTY": True},
    "one stays after a cancel": {"CANCEL_KEEPS": [True, False], "MIXED": True},
    "what is found active goes": {"START_KEEPS": [False, False]},
    "one stays after a death": {"DEATH_KEEPS": [False, True], "MIXED": True},
    "none stays after a loss": {"LOSS_KEEPS": [False, False]},
    "blown off": {
        "BLOWS": True,
        "T_BLOW": [200, 0],
        "T_GAP": [150, 150],
        "IL_08_GAP": [50, 50],
        "RELEASE_BOUND": 10**6,
        "CANCEL_BOUND": 10**6,
        "GRIP_BOUND": 10**6,
    },
}


@pytest.mark.timeout(3600)
@pytest.mark.parametrize("other", first_of(OTHERS, thinned=0))
def test_so_it_does_with_other_declarations(other: str) -> None:
    _, failing = explored(network(text(), sized(2, **OTHERS[other])))
    assert failing == []


def test_only_free_sensors_find_that_a_line_is_activated_after_a_refusal() -> None:
    """The reading of an actuator that is not active yet shows a part: then one reaction activates two of them."""
    source = text()
    assert source.count(AFTER_A_REFUSAL) == 1
    mutant = source.replace(AFTER_A_REFUSAL, "")
    assert explored(network(mutant, sized(2), None))[1] == []
    assert explored(network(mutant, sized(2)))[1] == ["will-adopted"]


@pytest.mark.timeout(3600)
@first_of_each(
    [
        {"edited": mutant.get("template", ""), **mutant}
        for mutant in MUTANTS
        # ordinarily those of two steps: three take a minute
        if mutant["caught_by"] != "time" and (NIGHTLY or "constants" not in mutant)
    ][:: 1 if NIGHTLY else 6],
    "edited",
)
def test_what_ordinary_sensors_find_out_free_ones_find_out(mutant: Mutant) -> None:
    """The same requirement does. Of [time] there is nothing to compare."""
    constants = sized(3 if "constants" in mutant else 2, FREE_SENSORS=True)
    assert Shipped(text(), constants).catches(mutant), f"{mutant['name']}: survives"


def test_a_proof_with_free_sensors_asks_for_timelocks_alone() -> None:
    free = network(text(), sized(1))
    last = prove(free, flickers=True).findings[-1]
    assert (last.id, last.holds) == ("timelock", True)
    asked = prove(free).findings[-1]
    assert (asked.id, asked.holds) == ("time", False)
    assert any("Sensors stays in Free" in line for line in asked.trace.lines)


def test_automata_without_the_constant_are_told() -> None:
    source = text().replace("FREE_TOOL = false", "FREE_NOTHING = false").replace("FREE_TOOL", "FREE_NOTHING")
    assert free_constants(make_network(read_document(source.encode(), "tool.xml")), "actuators")
    with pytest.raises(UsageError, match="no constant FREE_TOOL"):
        network(source, sized(1), "all")
