"""The tools of `examples/tools`, with the testbench at the other end of their wires."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from end_effector_hal.codecs import load_tool
from end_effector_hal.control import Status
from end_effector_hal.errors import LineBusyError, NotReadyError
from end_effector_hal.runtime import EndEffector, Refused
from end_effector_hal.vocabulary import Command, EndEffectorState, Evidence
from end_effector_hal.wires import Claim
from end_effector_lab.demo._world import World
from tests.support.command import eehal, eehal_here
from tests.support.nightly import first_of
from tests.support.patience import wait_until

from .conftest import ROOT

pytestmark = [pytest.mark.wall, pytest.mark.timeout(300)]
TOOLS = ROOT / "examples/tools"
READY_S = 60.0
PLAYED = (
    "two_coil_changer",
    "diy_vacuum",
    "double_acting_jaw",
    "bistable_and_magnet",
    "area_gripper",
    "six_cups",
)


@pytest.mark.thinned
@pytest.mark.parametrize("name", first_of(PLAYED, 1, 0))
def test_it_is_checked_verified_demonstrated_recorded_and_replayed(name: str, tmp_path: Path) -> None:
    tool = TOOLS / name / "end_effector.yaml"
    assert json.loads(eehal_here("check", tool, "--json"))["warnings"] == []
    proof = json.loads(eehal_here("verify", tool, "--json"))
    assert all(each["holds"] for each in proof["requirements"])
    eehal("demo", tool, "--no-ros", "--only", "nominal", "-o", tmp_path)  # 1 if it is another story
    run = tmp_path / "nominal"
    assert (run / "timeline.svg").stat().st_size > 1000
    description = load_tool(tool)
    states = [row.split(",") for row in (run / "states.csv").read_text("utf-8").splitlines()]
    assert states[0][3:] == list(description.sequence)
    assert "decisions, all identical" in eehal_here("replay", run)


@pytest.fixture
def six_cups(tmp_path: Path) -> Iterator[World]:
    with World(load_tool(TOOLS / "six_cups/end_effector.yaml"), "nominal", tmp_path) as world:
        yield world


@pytest.fixture
def diy_vacuum(tmp_path: Path) -> Iterator[World]:
    with World(load_tool(TOOLS / "diy_vacuum/end_effector.yaml"), "nominal", tmp_path) as world:
        yield world


def shows(tool: EndEffector, what: str) -> bool:
    return any(what in alarm for alarm in tool.status.alarm_texts)


def test_a_switch_that_is_stuck_refuses_a_grip(six_cups: World) -> None:
    with EndEffector.open(six_cups.description) as tool:
        tool.wait_ready(READY_S)
        six_cups.choose("shows:cup_3:60")
        wait_until("it is seen", lambda: tool.status.evidence[2] is Evidence.CONFIRMED)
        refused = tool.begin(Command.GRIP)
        assert isinstance(refused, Refused)
        assert "IL-07" in refused.reason
        assert "Cup 3" in refused.reason
        six_cups.choose("nominal")
        wait_until("it is seen", lambda: tool.status.evidence[2] is Evidence.GONE)
        assert tool.grip().succeeded


def test_a_switch_that_opens_while_a_part_is_held_is_a_lost_grip_at_once(six_cups: World) -> None:
    seen: list[Status] = []
    with EndEffector.open(six_cups.description) as tool:
        tool.wait_ready(READY_S)
        assert tool.grip().succeeded
        tool.subscribe(seen.append)
        six_cups.choose("shows:cup_5:0")
        wait_until("the alarm", lambda: tool.status.ee is EndEffectorState.GRIP_ERROR)
        assert all(tool.status.outputs)  # nothing but a Drop releases it
        six_cups.choose("nominal")
        assert tool.drop().succeeded


def test_an_input_line_in_use_is_refused_with_who_has_it(six_cups: World) -> None:
    claim = Claim(f"{six_cups.chip}.inputs.lock", "an input line of the virtual chip")
    with pytest.raises(LineBusyError, match=r"an input line of the virtual chip is held by pid \d+"):
        EndEffector.open(six_cups.description)
    claim.release()
    with EndEffector.open(six_cups.description) as tool:
        tool.wait_ready(READY_S)


def test_an_analog_file_that_is_gone_holds_what_is_held_and_refuses_a_grip(diy_vacuum: World) -> None:
    with EndEffector.open(diy_vacuum.description) as tool:
        tool.wait_ready(READY_S)
        assert tool.grip().succeeded
        diy_vacuum.choose("invalid:cup")
        wait_until("it is stale", lambda: tool.status.evidence[0] is Evidence.UNKNOWN)
        assert tool.status.ee is EndEffectorState.GRIPPED
        assert all(tool.status.outputs)
        assert tool.inputs is not None
        assert "cup cannot be read" in tool.inputs.error
        diy_vacuum.choose("nominal")
        wait_until("it is read", lambda: tool.status.evidence[0] is Evidence.CONFIRMED)
        assert tool.drop().succeeded
        diy_vacuum.choose("invalid:cup")
        wait_until("the alarm", lambda: shows(tool, "No valid reading of cup"))
        assert isinstance(tool.begin(Command.GRIP), Refused)


def test_a_tool_whose_inputs_say_nothing_is_not_ready_and_says_why(diy_vacuum: World) -> None:
    diy_vacuum.choose("invalid:cup")
    with EndEffector.open(diy_vacuum.description) as tool:
        with pytest.raises(NotReadyError) as refused:
            tool.wait_ready(1.5)
        assert "inputs of the board are not read: cup cannot be read" in str(refused.value)
        assert "in_voltage0_raw: No such file" in str(refused.value)
        assert tool.link is None
