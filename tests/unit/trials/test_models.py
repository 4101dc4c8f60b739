"""Cells of tools whose devices have a model, each of which a rule once objected to."""

from __future__ import annotations

from functools import cache

import pytest

from end_effector_hal.codecs import load_tool
from end_effector_hal.description import Description
from end_effector_hal.vocabulary import EndEffectorState, Evidence
from end_effector_lab.trials import Cell, cells_of, moments, play_case
from end_effector_lab.trials._effects import Effects
from tests.support.places import ROOT

CELLS = [
    # a write whose answer is lost, or that is never heard
    ("gripper_2f85", "silent-after:0 @ grip fingers on +1ms + cancel", "RELEASE_ERROR"),
    ("epick_commanded", "silent-after:0 @ grip cup on + none", "RELEASE_ERROR"),
    # a last will activates no device that has restarted: that waits for a Drop
    ("gripper_2f85", "reboot-after:0 @ grip GRIPPED -1ms + kill both", "STAND_BY"),
    ("gripper_2f85", "reboot-after:0 @ grip fingers on, between + kill hal", "STAND_BY"),
]


@cache
def grid(name: str) -> tuple[Description, dict[str, Cell]]:
    description = load_tool(ROOT / "examples/tools" / name / "end_effector.yaml")
    return description, {each.id: each for each in cells_of(description, moments(description))}


@pytest.mark.parametrize(("tool", "cell", "state"), CELLS)
def test_what_a_device_has_not_obeyed_is_shown(tool: str, cell: str, state: str) -> None:
    description, cells = grid(tool)
    trial = play_case(description, cells[cell].case)
    assert trial.failures == {}
    ended = trial.tool.statuses[trial.ended.statuses - 1]
    assert ended.ee is EndEffectorState[state]
    assert ended.evidence[0] is not Evidence.GONE


def test_a_release_keeps_its_order_if_all_processes_die_before_the_first_write() -> None:
    """The cup lets go before the lift moves: the last will counts from the release that is written again."""
    description, cells = grid("remote_io")
    trial = play_case(description, cells["nominal @ release cup off + kill both"].case)
    assert trial.failures == {}
    cup, lift = [each.at for each in trial.tool.edges if not each.level][:2]
    assert lift - cup > description.actuators["cup"].release_s * 0.99e6


@pytest.mark.parametrize("tool", ["remote_io", "gripper_2f85"])
def test_what_another_client_writes_is_explained_and_no_fault_of_an_order(tool: str) -> None:
    description, cells = grid(tool)
    mine = [each for name, each in cells.items() if each.fault == "foreign-write-after:0"]
    for cell in mine[::60]:
        assert play_case(description, cell.case).failures == {}, cell.id


def test_an_open_wire_at_an_input_of_a_modelled_board_is_a_lost_part() -> None:
    description = load_tool(ROOT / "examples/cells/three_parts/end_effector.yaml")
    effects = Effects(description, "invalid:left", "held", ("left", "right"), "sheet")
    assert (effects.views["left"].keeps, effects.views["right"].keeps) == ({"lost"}, {"yes"})
    assert not effects.refuses_grip, "it reads as nothing gripped"
