"""Which joints a tool has, and where they stand; what Position publishes of them. It needs no ROS."""

from __future__ import annotations

from math import isnan
from pathlib import Path

import pytest

from end_effector_hal.description import Description, load
from end_effector_hal.nodes.interface import actuator_joints, grip_joint, grip_position
from end_effector_hal.vocabulary import Evidence

TOOL = """\
name: tool
link: {port: /dev/ttyS0}
sequence: [cup, rod, grip]
actuators:
  cup: {kind: vacuum, line: A, channel: bottom}
  rod: {kind: cylinder, line: B, channel: cylinder}
  grip: {kind: cylinder, line: C, channel: top, extended_bit: none, retracted_bit: none, stroke_mm: 25}
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
    assert grip_position([Evidence.CONFIRMED] * 3) == 0.0
    assert grip_position([Evidence.GONE] * 3) == 1.0
    for evidence in (
        [Evidence.UNKNOWN] * 3,
        [Evidence.PARTIAL] * 3,
        [Evidence.CONFIRMED, Evidence.GONE],
        [9],
    ):
        assert isnan(grip_position(evidence))
