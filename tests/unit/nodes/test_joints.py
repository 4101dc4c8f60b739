"""Which joints a tool has, and where they stand; what Position publishes of them. It needs no ROS."""

from __future__ import annotations

from math import isnan
from pathlib import Path
from typing import Any, cast

import pytest

from end_effector_hal.description import Description, load
from end_effector_hal.nodes._position import PositionNode
from end_effector_hal.nodes.interface import (
    JOINT_STATES,
    POSITION_TOOL_CHANGER,
    POSITION_TOOL_STAND,
    STATE_HZ,
    actuator_joints,
    grip_joint,
    grip_position,
)
from end_effector_hal.vocabulary import Evidence
from tests.support.lone_node import LoneTransport, status
from tests.support.parts import with_parts

TOOL = """\
name: tool
link: {port: /dev/ttyS0}
sequence: [cup, rod, grip]
actuators:
  cup: {kind: vacuum, line: A, channel: bottom}
  rod: {kind: cylinder, line: B, channel: cylinder}
  grip: {kind: cylinder, line: C, channel: top, extended_bit: in_stand, retracted_bit: none, stroke_mm: 25}
"""


@pytest.fixture
def tool(tmp_path: Path) -> Description:
    path = tmp_path / "tool.yaml"
    path.write_text(TOOL, encoding="utf-8")
    return load(path)


def test_a_cylinder_has_a_joint_where_its_stroke_is_known(tool: Description) -> None:
    (joint,) = actuator_joints(tool)
    assert (joint.name, joint.actuator, joint.index) == ("tool_grip_joint", "grip", 2)
    assert joint.travel == ("prismatic", 0.025)
    assert grip_joint(tool) == "tool_joint"


def test_a_joint_stands_where_its_own_evidence_proves_it(tool: Description) -> None:
    (joint,) = actuator_joints(tool)
    assert joint.position([Evidence.UNKNOWN, Evidence.PARTIAL, Evidence.CONFIRMED]) == 0.025
    assert joint.position([Evidence.CONFIRMED, Evidence.CONFIRMED, Evidence.GONE]) == 0.0
    for level in (Evidence.UNKNOWN, Evidence.PARTIAL, 9):
        assert isnan(joint.position([Evidence.CONFIRMED, Evidence.CONFIRMED, level]))


def test_the_tool_is_gripped_or_released_only_as_a_whole() -> None:
    assert grip_position([Evidence.CONFIRMED] * 3, [True] * 3) == 0.0
    assert grip_position([Evidence.GONE] * 3, [True] * 3) == 1.0
    for evidence in (
        [Evidence.UNKNOWN] * 3,
        [Evidence.PARTIAL] * 3,
        [Evidence.CONFIRMED, Evidence.GONE],
        [9],
    ):
        assert isnan(grip_position(evidence, [True] * len(evidence)))


def test_what_does_not_grip_the_part_needs_no_evidence_while_it_is_gripped() -> None:
    uses = [False, True]
    assert grip_position([Evidence.PARTIAL, Evidence.CONFIRMED], uses) == 0.0
    assert isnan(grip_position([Evidence.PARTIAL, Evidence.GONE], uses))
    assert grip_position([Evidence.GONE, Evidence.GONE], uses) == 1.0


def test_a_joint_is_published_at_once_repeated_and_left_out_when_it_is_not_proven(tool: Description) -> None:
    transport = LoneTransport(tool)
    PositionNode(cast("Any", transport))
    published, tick = transport.published[JOINT_STATES.name], transport.ticks[STATE_HZ]

    def shown(level: Evidence) -> None:
        transport.hal.says(status(evidence=(Evidence.UNKNOWN, Evidence.UNKNOWN, level)))

    def seen() -> list[dict[str, float]]:
        return [dict(zip(each.name, each.position, strict=True)) for each in cast("list[Any]", published)]

    shown(Evidence.UNKNOWN)
    tick()
    assert seen() == [], "nothing is proven before the first frame"
    shown(Evidence.CONFIRMED)
    assert seen() == [{"tool_grip_joint": 0.025}], "a change does not wait for the clock"
    shown(Evidence.CONFIRMED)
    assert len(seen()) == 1
    tick()
    assert seen() == [{"tool_grip_joint": 0.025}] * 2
    shown(Evidence.PARTIAL)
    tick()
    assert len(seen()) == 2, "on its way it stands nowhere"


def test_the_joint_of_the_tool_is_published_for_the_part_that_is_gripped(verdin: Description) -> None:
    transport = LoneTransport(with_parts(verdin))
    PositionNode(cast("Any", transport))
    evidence = (Evidence.GONE, Evidence.GONE, Evidence.CONFIRMED)
    transport.hal.says(status(evidence=evidence, part="panel"))
    assert JOINT_STATES.name not in {name for name, sent in transport.published.items() if sent}
    transport.hal.says(status(evidence=evidence, part="lid"))
    (joints,) = transport.published[JOINT_STATES.name]
    assert (joints.name, joints.position) == (["verdin_gripper_joint"], [0.0])


def test_the_changer_and_its_stand_stand_where_their_bits_say(caplog: pytest.LogCaptureFixture) -> None:
    transport = LoneTransport()
    PositionNode(cast("Any", transport))
    with caplog.at_level("INFO"):
        transport.hal.reads(locked=True, unlocked=False, tool_present=True, in_stand=True)
        transport.hal.reads(locked=False, unlocked=False, tool_present=True, in_stand=True)
        transport.hal.reads(locked=None, unlocked=False, tool_present=False, in_stand=True)
    assert [each.position_name for each in transport.published[POSITION_TOOL_CHANGER.name]] == [
        "LOCKED",
        "BETWEEN",
        "UNKNOWN",
    ]
    assert [each.position_name for each in transport.published[POSITION_TOOL_STAND.name]] == [
        "IN_STAND",
        "ABSENT",
    ]
    assert "tool_changer: LOCKED -> BETWEEN" in [each.getMessage() for each in caplog.records]
