"""The paper's Fig. 5: proven in its own size, and the specification of what the shipped grip does."""

from __future__ import annotations

from pathlib import Path

import pytest

from end_effector_hal.control import load_automata, model_constants
from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_hal.verification.lemmas import FIG5_FILE, compare_with_fig5, fig5_network, grips_as_fig5
from end_effector_hal.verification.proof import prove
from timed_automata import Network, load_network, make_network
from timed_automata.inclusion import Inclusion
from tools.mutants import Mutant, mutants

pytestmark = pytest.mark.timeout(300)
GRIP = ("Gripper", "Actuator")


@pytest.fixture(scope="module")
def network(verdin: Description) -> Network:
    return load_automata(verdin)


@pytest.mark.parametrize("late_ms", [0, 50])
def test_fig_5_is_proven_as_it_stands_and_with_lateness(late_ms: int) -> None:
    findings = prove(load_network(FIG5_FILE, {"D": late_ms})).findings
    assert [each.id for each in findings if not each.holds] == []
    assert len(findings) == 15


def test_the_file_has_the_times_of_the_shipped_tool(verdin: Description) -> None:
    """But for the lateness: the paper has none."""
    own, given = load_network(FIG5_FILE).constants, fig5_network(verdin).constants
    assert {name for name in own if own[name] != given[name]} == {"D"}


def test_the_shipped_grip_does_nothing_that_fig_5_does_not(verdin: Description, network: Network) -> None:
    report = compare_with_fig5(verdin, network)
    assert report.holds
    assert report.inclusion.states == 58


def test_so_does_one_that_is_never_late(verdin: Description, network: Network) -> None:
    ideal = make_network(network.document, model_constants(verdin) | {"D": 0})
    assert grips_as_fig5(ideal, GRIP, load_network(FIG5_FILE)).holds
    late = grips_as_fig5(network, GRIP, load_network(FIG5_FILE))
    assert "lets time pass" in late.difference  # Fig. 5 as it stands is never late


# What is not as in Fig. 5 is found


def compared(network: Network, tool: Description, **constants: object) -> Inclusion:
    other = make_network(network.document, model_constants(tool) | constants)  # type: ignore[arg-type]
    return grips_as_fig5(other, GRIP, fig5_network(tool))


CHANGED = {
    "two attempts": ({"ATTEMPTS": [[3, 2, 3]]}, 11010, "ee 1 → 2, command 2 → 3"),
    "a shorter pause": ({"T_RESET": [1000, 1000, 900]}, 5910, "actuator[2] 0 → 1, valve[2] 0 → 1"),
    "a longer time-out": ({"T_CONFIRM": [[6000, 5000, 5000]]}, 5061, "the implementation lets time pass"),
    "a shorter time-out": ({"T_CONFIRM": [[4999, 5000, 5000]]}, 5009, "actuator[0] 1 → 0, valve[0] 1 → 0"),
    "another release order": ({"RELEASE_ORDER": [0, 1, 2]}, 20, "input drop: ee 3 → 4"),
    "an output that stays active after a time-out": (
        {"TIMEOUT_KEEPS": [True, False, False], "MIXED": True},
        5061,
        "the implementation lets time pass",
    ),
}


@pytest.mark.parametrize(("constants", "end", "told"), CHANGED.values(), ids=CHANGED)
def test_another_grip_is_refuted_by_a_run(
    network: Network, verdin: Description, constants: dict[str, object], end: int, told: str
) -> None:
    found = compared(network, verdin, **constants)
    assert not found.holds
    assert told in found.difference
    assert found.end == end
    assert found.run[0].what.startswith("input grip: ee 6 → 1")


def edit(network: Network, element: str, new: str) -> Mutant:
    """The first of this kind in the file: of the edges from Step to Abort that of the last time-out."""
    return next(
        each for each in mutants(network.document, GRIP) if (each.element, each.new) == (element, new)
    )


EDITED = {
    "GRIP_ERROR is not told": ("Step -> Abort, assignment", "(GRIP_ERROR + 1)"),
    "an attempt is not timed": ("Activate -> Step, assignment", "attempt++"),
    "an actuator is told to be ON too early": ("Off -> Entered, assignment", "(PENDING + 1)"),
    "the time-out of the pause is not awaited": ("Reset -> Activate, guard", "true"),
    "a Drop homes what is proven gone": ("StandBy -> Unwind, guard", "true"),
}


@pytest.mark.parametrize(("element", "new"), EDITED.values(), ids=EDITED)
def test_an_edit_of_the_automata_is_refuted_by_a_run(
    network: Network, verdin: Description, element: str, new: str
) -> None:
    edited = make_network(edit(network, element, new).document, model_constants(verdin))
    found = grips_as_fig5(edited, GRIP, fig5_network(verdin))
    assert not found.holds
    assert found.lines


def test_a_tool_of_another_size_cannot_be_compared(tmp_path: Path, verdin: Description) -> None:
    sequence = list(verdin.sequence)[:2]
    smaller = verdin.model_copy(update={"sequence": sequence})
    with pytest.raises(UsageError, match=r"Fig\. 5 has 3 devices, this tool 2"):
        fig5_network(smaller)
