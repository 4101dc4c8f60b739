"""``eehal export``: a xacro of a tool, in which EDIT marks the values that the description does not contain."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import click

from end_effector_hal.description import Description, profile_path
from end_effector_hal.nodes.interface import (
    GRIP_UPPER,
    actuator_joints,
    grip_joint,
    load_for_nodes,
)

from ._options import PathName, write_or_print


@click.group(name="export")
def command() -> None:
    """Write files about a tool for other programs."""


_HEAD = """\
<?xml version="1.0"?>
<!-- The tool {tool}, written by `eehal export urdf` from its description ({fingerprint}).

     EDIT marks what the description does not contain: where the parts sit, along which axis they move, their shapes and
     masses. No link has a shape yet: a planner does not see the tool, and moves as if it were not there.

     Joints are called as in joint_states and in MoveIt's controllers; other names are free.

     In a robot:
       <xacro:arg name="{tool}_alone" default="false"/>
       <xacro:include filename="{tool}.urdf.xacro"/>
       <xacro:mount_{tool} parent="tool0"><origin xyz="0 0 0" rpy="0 0 0"/></xacro:mount_{tool}>
-->
<robot name="{tool}" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="{tool}_alone" default="true"/>
  <xacro:macro name="mount_{tool}" params="parent *origin plugin:=mock_components/GenericSystem">
"""
_TAIL = """\
  </xacro:macro>

  <!-- without a robot, to look at it -->
  <xacro:if value="$(arg {tool}_alone)">
    <link name="world"/>
    <xacro:mount_{tool} parent="world"><origin xyz="0 0 0" rpy="0 0 0"/></xacro:mount_{tool}>
  </xacro:if>
</robot>
"""
_BASE = """\
    <link name="{tool}_link"/>  <!-- EDIT: visual, collision, inertial -->
    <joint name="{tool}_mount" type="fixed">
      <parent link="${{parent}}"/>
      <child link="{tool}_link"/>
      <xacro:insert_block name="origin"/>
    </joint>

    <!-- EDIT: where it grips -->
    <link name="{tool}_tcp"/>
    <joint name="{tool}_tcp_fixed" type="fixed">
      <parent link="{tool}_link"/>
      <child link="{tool}_tcp"/>
      <origin xyz="0 0 0" rpy="0 0 0"/>
    </joint>

    <!-- The whole tool: 0 gripped, {upper:g} released, and nothing between. It moves nothing; jaws that shall be seen
         are joints that mimic it, with their opening in metres as the multiplier. So slow that a planner waits for
         the longest grip that the description allows, {grip_s:g} s. -->
    <link name="{tool}_grip"/>
    <joint name="{joint}" type="revolute">
      <parent link="{tool}_link"/>
      <child link="{tool}_grip"/>
      <axis xyz="0 0 1"/>
      <limit lower="0" upper="{upper:.10g}" effort="0" velocity="{velocity:.6g}"/>
    </joint>
"""
_ACTUATOR = """
    <!-- {what} -->
    <link name="{tool}_{actuator}_link"/>  <!-- EDIT: visual, collision, inertial -->
    <joint name="{tool}_{actuator}_joint" type="{type}">
      <parent link="{tool}_link"/>  <!-- EDIT: or the part that carries it -->
      <child link="{tool}_{actuator}_link"/>
      <origin xyz="0 0 0" rpy="0 0 0"/>  <!-- EDIT -->{moves}
    </joint>
"""
_FIXED = "fixed, for its description names no way that it travels"
_MOVES = """
      <axis xyz="0 0 1"/>  <!-- EDIT -->
      <limit lower="0" upper="{upper:.10g}" effort="0" velocity="{velocity:.6g}"/>"""
_HARDWARE = """
    <!-- What a hardware component of ros2_control would offer (docs/reference/ros2.md). The plugin named here drives
         nothing: it is the stand-in of ros2_control. The nodes of the tool do not need this element. -->
    <ros2_control name="{tool}" type="system">
      <hardware>
        <plugin>${{plugin}}</plugin>
      </hardware>
"""
_TOOL_STATES = ("state", "command", "held", "lift_allowed", "secure", "link_up")
_CHANGER_STATES = ("tool_changer", "unlock_output")
_ACTUATOR_STATES = ("state", "output", "evidence", "margin")


@command.command(name="urdf", short_help="A xacro with its links, joints and ros2_control entries.")
@click.argument("file", type=PathName(), required=False)
@click.option("-o", "--output", metavar="FILE", type=PathName(), help="Default: stdout.")
def export_urdf(file: Path | None, output: Path | None) -> None:
    """Write a xacro of the tool of the description FILE; default: the shipped one.

    Its names are those of joint_states. A description contains no dimensions except strokes: places, axes, shapes and
    masses are marked EDIT, and until they are filled in a planner does not see the tool.
    """
    description = load_for_nodes(file or profile_path())
    write_or_print(output, urdf(description), description.files)


def urdf(description: Description) -> str:
    """Return the xacro; the same description gives the same text."""
    return "".join(_parts(description))


def _parts(description: Description) -> Iterator[str]:
    tool = description.name
    yield _HEAD.format(tool=tool, fingerprint=description.fingerprint())
    longest_s = max(description.durations.grip_ms, description.durations.release_ms) / 1000
    yield _BASE.format(
        tool=tool, joint=grip_joint(description), upper=GRIP_UPPER, velocity=GRIP_UPPER / longest_s,
        grip_s=longest_s,
    )  # fmt: skip
    travels = {joint.actuator: joint.travel for joint in actuator_joints(description)}
    for name, actuator in description.ordered:
        travel = travels.get(name)
        yield _ACTUATOR.format(
            tool=tool, actuator=name, type=travel.joint if travel else "fixed",
            what=f"{actuator.kind}: {'0 released, its upper limit active' if travel else _FIXED}",
            moves=_MOVES.format(upper=travel.upper, velocity=travel.upper / actuator.timeout_s) if travel else "",
        )  # fmt: skip
    yield _HARDWARE.format(tool=tool)
    yield from _ros2_control(description)
    yield "    </ros2_control>\n"
    yield _TAIL.format(tool=tool)


def _ros2_control(description: Description) -> Iterator[str]:
    tool = description.name
    limits = f'<param name="min">0</param><param name="max">{GRIP_UPPER:g}</param>'
    position = f'<command_interface name="position">{limits}</command_interface>'
    yield from _component("joint", grip_joint(description), ("position",), position)
    for joint in actuator_joints(description):
        yield from _component("joint", joint.name, ("position",))
    changer = _CHANGER_STATES if description.tool_changer else ()
    yield from _component("gpio", tool, (*_TOOL_STATES, *changer), '<command_interface name="command"/>')
    for name in description.sequence:
        yield from _component("gpio", f"{tool}_{name}", _ACTUATOR_STATES)


def _component(element: str, name: str, states: tuple[str, ...], command: str = "") -> Iterator[str]:
    yield f'      <{element} name="{name}">\n'
    if command:
        yield f"        {command}\n"
    yield from (f'        <state_interface name="{state}"/>\n' for state in states)
    yield f"      </{element}>\n"
