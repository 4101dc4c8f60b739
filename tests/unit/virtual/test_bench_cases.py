"""Cases from the bench (docs/explanation/bench.md) that no other file plays."""

from __future__ import annotations

from pathlib import Path

from end_effector_hal.codecs import load_tool
from end_effector_hal.control import event_lines
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_lab.virtual import VirtualTool
from tests.unit.virtual.test_unread_outputs import until

STAND_BY, GRIPPED = EndEffectorState.STAND_BY, EndEffectorState.GRIPPED
BLOWN = """
schema: 2
name: blown
link: {port: /dev/ttyS0, frame: {text: {start: "$", separator: ",", checksum: xor8}}}
channels:
  cup_pa: {text: {field: 1, decimals: 1}, unit: kPa}
  stop: {text: {field: 2}, on: [1]}
sequence: [cup]
actuators:
  cup: {kind: vacuum, line: GPIO1, channel: cup_pa, blow_off: {line: GPIO2, duration_s: 0.3}}
e_stop: {channel: stop}
supply: {channel: none}
"""
ABSOLUTE = """
schema: 2
name: absolute
link: {port: /dev/ttyS0, frame: {text: {start: "$", separator: ",", checksum: xor8}}}
channels:
  cup_pa: {text: {field: 1}, unit: hPa, offset: -1013.25}
sequence: [cup]
actuators:
  cup: {kind: vacuum, line: GPIO1, channel: cup_pa}
supply: {channel: none}
"""
RELAYS = """
schema: 2
name: relays
link: {port: /dev/ttyUSB0, baudrate: 9600, frame: {modbus: {}}}
channels:
  seen: {modbus: {unit: 255, address: 0, register_type: discrete_input}}
  coil: {modbus: {unit: 255, address: 0, register_type: coil}}
sequence: [cup]
actuators:
  cup:
    kind: vacuum
    modbus: {unit: 255, address: 0, register_type: coil, command_on: [1], command_off: [0], verify: coil}
    channel: seen
    on_power_loss: release
supply: {channel: none}
"""


def played(text: str, folder: Path, scenario: str = "nominal") -> VirtualTool:
    path = folder / "end_effector.yaml"
    path.write_text(text, encoding="utf-8")
    tool = VirtualTool(load_tool(path), scenario)
    tool.run(2.0)
    return tool


def gripped(tool: VirtualTool) -> None:
    assert tool.command("grip").accepted
    until(tool, GRIPPED)


def test_a_blow_off_that_an_open_e_stop_refuses_is_not_called_done(tmp_path: Path) -> None:
    tool = played(BLOWN, tmp_path)
    gripped(tool)
    tool.choose("estop-open")
    tool.run(0.5)
    seen = len(tool.statuses)
    assert tool.command("drop").accepted
    until(tool, STAND_BY)
    told = [line for each in tool.statuses[seen:] for line in event_lines(tool.description, each)]
    assert not any("blown off" in line for line in told), told
    assert (
        tool.status.reason == "IL-13: GPIO2 (blow-off of cup) is not activated: the emergency stop is open."
    )
    assert [(each.line, each.level) for each in tool.edges] == [("GPIO1", True), ("GPIO1", False)]


def test_a_sensor_with_a_wrong_zero_is_refused_with_value_threshold_and_remedy(tmp_path: Path) -> None:
    """845 hPa at rest, where the description expects 1013."""
    tool = played(ABSOLUTE, tmp_path, "shows:cup:-16.8")
    refused = tool.command("grip")
    assert not refused.accepted
    for said in (
        "cup_pa is at -16.",
        "gone means less than 10 kPa below ambient",
        "correct its offset at rest",
    ):
        assert said in refused.reason, refused.reason


def test_a_relay_board_at_unit_255_grips_and_drops(tmp_path: Path) -> None:
    tool = played(RELAYS, tmp_path)
    gripped(tool)
    assert list(tool.levels) == ["modbus:255/0x0000"]
    assert tool.command("drop").accepted
    until(tool, STAND_BY)
