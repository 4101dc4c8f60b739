"""``eehal export``: a tool for other programs.

A xacro, in which EDIT marks the values that the description does not contain; a layout for Foxglove, or Lichtblick,
with the topics of the tool; an SROS 2 policy.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click

from end_effector_hal.description import Description, profile_path
from end_effector_hal.kinds.stanza import NO_CHANNEL
from end_effector_hal.nodes.interface import (
    DIAGNOSTICS,
    END_EFFECTOR_STATE,
    GRIP_UPPER,
    Topic,
    actuator_joints,
    grip_joint,
    load_for_nodes,
    pressure_topics,
)
from end_effector_hal.vocabulary import display_name

from ._options import PathName, write_or_print
from ._sros2 import export_sros2


@click.group(name="export")
def command() -> None:
    """Write files about a tool for other programs."""


command.add_command(export_sros2)


GREEN, GREY, RED = "#009e73", "#9e9e9e", "#d55e00"  # told apart by colour-blind people


@command.command(name="foxglove", short_help="A layout for Foxglove with the topics of the tool.")
@click.argument("file", type=PathName(), required=False)
@click.option("--namespace", metavar="NS", default="", help="ROS namespace of the tool, such as /left.")
@click.option("-o", "--output", metavar="FILE", type=PathName(), help="Default: stdout.")
def export_foxglove(file: Path | None, namespace: str, output: Path | None) -> None:
    """Write a Foxglove layout for the tool of the description FILE; default: the shipped one.

    Import it with "Import from file…" and connect to the robot by foxglove_bridge, or open a bag. The layout only
    shows the tool and sends no command.
    """
    description = load_for_nodes(file or profile_path())
    write_or_print(output, foxglove_layout(description, namespace), description.files)


def foxglove_layout(description: Description, namespace: str = "") -> str:
    """Return the layout as JSON; the same description gives the same text."""
    panels = dict(_panels(description, namespace))
    layout = {
        "configById": panels,
        "globalVariables": {},
        "userNodes": {},
        "playbackConfig": {"speed": 1},
        "layout": _split(
            "row",
            _split("column", "StateTransitions!states", "Plot!pressures", 45),
            _split(
                "column",
                _split("row", "Indicator!held", "Indicator!lift", 50),
                _split(
                    "column",
                    "RawMessages!reason",
                    _split("column", "DiagnosticSummary!health", "RosOut!log", 40),
                    25,
                ),
                15,
            ),
            65,
        ),
    }
    return json.dumps(layout, indent=2, ensure_ascii=False) + "\n"


def _panels(description: Description, namespace: str) -> Iterator[tuple[str, dict[str, Any]]]:
    state = _name(END_EFFECTOR_STATE, namespace)
    states = {f"{state}.state_name": "End-effector", f"{state}.command_name": "Command"}
    for index, name in enumerate(description.sequence):
        states[f"{state}.actuator_states[{index}]"] = display_name(name)
    if description.tool_changer is not None:
        states[f"{state}.tool_changer_name"] = "Tool changer"
    yield "StateTransitions!states", {"paths": _paths(states), "isSynced": True}
    pressures = {
        f"{_name(topic, namespace)}.fluid_pressure": f"{topic.name} (Pa, absolute)"
        for channel, topic in pressure_topics(description)
        if channel != NO_CHANNEL
    }
    yield "Plot!pressures", {
        "paths": _paths(pressures), "showXAxisLabels": True, "showYAxisLabels": True, "showLegend": True,
        "legendDisplay": "floating", "isSynced": True, "xAxisVal": "timestamp", "sidebarDimension": 240,
    }  # fmt: skip
    yield "Indicator!held", _indicator(f"{state}.held", "HELD", "nothing held")
    yield "Indicator!lift", _indicator(f"{state}.lift_allowed", "LIFT ALLOWED", "no lift")
    yield "RawMessages!reason", {
        "topicPath": f"{state}.reason", "diffEnabled": False, "diffMethod": "custom", "diffTopicPath": "",
        "showFullMessageForDiff": False,
    }  # fmt: skip
    yield "DiagnosticSummary!health", {
        "minLevel": 0, "pinnedIds": [], "hardwareIdFilter": description.name,
        "topicToRender": DIAGNOSTICS.name, "sortByLevel": True,
    }  # fmt: skip
    yield "RosOut!log", {"topicToRender": "/rosout", "searchTerms": [], "minLogLevel": 2}


def _name(topic: Topic, namespace: str) -> str:
    return "/" + "/".join(filter(None, (namespace.strip("/"), topic.name)))


def _paths(labels: dict[str, str]) -> list[dict[str, object]]:
    return [
        {"value": value, "label": label, "enabled": True, "timestampMethod": "headerStamp"}
        for value, label in labels.items()
    ]


def _indicator(path: str, yes: str, no: str) -> dict[str, object]:
    rules = [
        {"operator": "=", "rawValue": raw, "color": color, "label": label}
        for raw, color, label in (("true", GREEN, yes), ("false", GREY, no))
    ]
    return {
        "path": path,
        "style": "background",
        "fallbackColor": RED,
        "fallbackLabel": "no news",
        "rules": rules,
    }


def _split(direction: str, first: object, second: object, percent: int) -> dict[str, object]:
    return {"direction": direction, "first": first, "second": second, "splitPercentage": percent}


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
