"""``eehal export urdf``: xacro and ``check_urdf`` accept it, and its names are those of the nodes."""

from __future__ import annotations

import shutil
import subprocess
import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner

from end_effector_hal.cli._main import eehal
from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import DescriptionError
from end_effector_hal.nodes.interface import GRIP_UPPER, actuator_joints, grip_joint

xacro = pytest.importorskip("xacro", reason="make setup installs it")

TOOL = """\
name: NAME
link: {port: /dev/ttyS0}
sequence: [cup, grip, joint]
actuators:
  cup: {kind: vacuum, line: A, channel: bottom}
  grip: {kind: cylinder, line: B, channel: cylinder, stroke_mm: 1234.567}
  joint: {kind: cylinder, line: C, channel: top, extended_bit: none, retracted_bit: none, stroke_mm: 25, timeout_s: 2}
bounds: {grip_s: 40}
"""
"""Actuators that are called like the tool's own joints and links."""


@pytest.fixture
def tool(tmp_path: Path) -> Callable[[str], Path]:
    """Writes a description and its xacro beside it; gives the path of the description."""

    def write(name: str) -> Path:
        path = tmp_path / f"{name}.yaml"
        path.write_text(TOOL.replace("NAME", name), encoding="utf-8")
        output = tmp_path / f"{name}.urdf.xacro"
        done = CliRunner().invoke(
            eehal, ["export", "urdf", str(path), "-o", str(output)], catch_exceptions=False
        )
        assert (done.exit_code, done.stdout) == (0, f"{output}\n")
        return path

    return write


def expanded(path: Path, tmp_path: Path) -> ET.Element:
    """The URDF that a user gets; ``check_urdf`` has accepted it."""
    text = xacro.process_file(str(path)).toprettyxml()
    if program := shutil.which("check_urdf"):
        urdf = tmp_path / "robot.urdf"
        urdf.write_text(text, encoding="utf-8")
        checked = subprocess.run([program, str(urdf)], capture_output=True, text=True, check=False)
        assert checked.returncode == 0, checked.stdout + checked.stderr
        assert "Successfully Parsed XML" in checked.stdout
    return ET.fromstring(text)


def moving(robot: ET.Element) -> dict[str, tuple[str, float]]:
    """The joints that move, with their types and upper limits."""
    found = {}
    for joint in robot.findall("joint"):
        if joint.get("type") != "fixed":
            limit = joint.find("limit")
            assert (limit.get("lower"), limit.get("effort")) == ("0", "0")
            found[joint.get("name", "")] = (joint.get("type", ""), float(limit.get("upper", "")))
    return found


def test_what_moves_is_what_joint_states_names(tool: Callable[[str], Path], tmp_path: Path) -> None:
    description = load(tool("clamp"))
    robot = expanded(tmp_path / "clamp.urdf.xacro", tmp_path)
    expected = {each.name: (each.travel.joint, each.travel.upper) for each in actuator_joints(description)}
    assert len(expected) == 2
    assert moving(robot) == {**expected, grip_joint(description): ("revolute", GRIP_UPPER)}


def test_every_name_stands_once(tool: Callable[[str], Path], tmp_path: Path) -> None:
    tool("if")
    robot = expanded(tmp_path / "if.urdf.xacro", tmp_path)
    for element in ("link", "joint"):
        names = [each.get("name") for each in robot.findall(element)]
        assert len(names) == len(set(names))
    assert {f"if_{name}_link" for name in ("cup", "grip", "joint")} <= {
        each.get("name") for each in robot.findall("link")
    }


def test_a_planner_waits_for_the_longest_grip(tool: Callable[[str], Path], tmp_path: Path) -> None:
    tool("clamp")
    robot = expanded(tmp_path / "clamp.urdf.xacro", tmp_path)
    limits = {each.get("name"): each.find("limit") for each in robot.findall("joint")}
    velocity = {name: float(each.get("velocity", "")) for name, each in limits.items() if each is not None}
    assert velocity == {"clamp_joint": 0.025, "clamp_grip_joint": 0.246913, "clamp_joint_joint": 0.0125}


def test_ros2_control_names_joints_that_are_there_and_every_actuator(
    tool: Callable[[str], Path], tmp_path: Path
) -> None:
    tool("clamp")
    robot = expanded(tmp_path / "clamp.urdf.xacro", tmp_path)
    (control,) = robot.findall("ros2_control")
    assert control.findtext("hardware/plugin") == "mock_components/GenericSystem"
    assert {each.get("name") for each in control.findall("joint")} == moving(robot).keys()
    assert [each.get("name") for each in control.findall("gpio")] == [
        "clamp", "clamp_cup", "clamp_grip", "clamp_joint",
    ]  # fmt: skip
    commands = [
        (owner.get("name"), each.get("name"))
        for owner in control
        for each in owner.findall("command_interface")
    ]
    assert commands == [("clamp_joint", "position"), ("clamp", "command")], (
        "a single output is never commanded"
    )
    assert "tool_changer" not in {each.get("name") for each in control.iter("state_interface")}


def test_two_tools_on_one_robot(tool: Callable[[str], Path], tmp_path: Path) -> None:
    mounts = ""
    for name in ("left", "right"):
        tool(name)
        mounts += f"""
  <xacro:arg name="{name}_alone" default="false"/>
  <xacro:include filename="{name}.urdf.xacro"/>
  <xacro:mount_{name} parent="tool0"><origin xyz="0 0 0.1" rpy="0 0 0"/></xacro:mount_{name}>"""
    robot = tmp_path / "robot.urdf.xacro"
    robot.write_text(
        f'<robot name="robot" xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="tool0"/>{mounts}\n</robot>'
    )
    links = {each.get("name") for each in expanded(robot, tmp_path).findall("link")}
    assert {"tool0", "left_link", "right_link", "left_tcp"} <= links
    assert "world" not in links


def test_the_shipped_tool_has_one_joint_and_says_what_to_edit(tmp_path: Path) -> None:
    done = CliRunner().invoke(eehal, ["export", "urdf"], catch_exceptions=False)
    path = tmp_path / "tool.xacro"
    path.write_text(done.stdout, encoding="utf-8")
    robot = expanded(path, tmp_path)
    assert list(moving(robot)) == ["verdin_gripper_joint"]
    assert "a planner does not see the tool" in " ".join(done.stdout.split())
    assert "tool_changer" in {each.get("name") for each in robot.iter("state_interface")}
    assert done.stdout == CliRunner().invoke(eehal, ["export", "urdf", str(profile_path())]).stdout


def test_a_description_with_a_fault_is_told_with_its_place(tmp_path: Path) -> None:
    path = tmp_path / "tool.yaml"
    path.write_text("name: tool\nactuators: 3\n", encoding="utf-8")
    done = CliRunner().invoke(eehal, ["export", "urdf", str(path)])
    assert isinstance(done.exception, DescriptionError)
    assert f"{path}:2:" in str(done.exception)
