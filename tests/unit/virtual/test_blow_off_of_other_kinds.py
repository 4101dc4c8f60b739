"""Magnets and grippers that blow off what they have released, with the line arbiter, in virtual time."""

from __future__ import annotations

from pathlib import Path

import pytest

from end_effector_hal.codecs import load_tool
from end_effector_hal.control import event_lines, network_of
from end_effector_hal.verification.lemmas import prove_tool
from end_effector_hal.vocabulary import EndEffectorState
from tests.support.nightly import first_of
from tests.unit.virtual.test_tool import GRIPPED, STAND_BY, ready, until

TOOL = """
schema: 2
name: blown
lines: {{backend: gpiod}}
inputs: {{period_ms: 10}}
channels:
  part: {{digital: {{line: PART}}}}
  opened: {{digital: {{line: OPEN}}}}
sequence: [holder]
actuators:
  holder: {{kind: {kind}, line: HOLD{keys}, part_bit: part{air}}}
supply: {{channel: none}}
"""
AIR = ", blow_off: {line: AIR, duration_s: 0.2}"
KINDS = {
    "magnet": ("magnet", ""),
    "switched magnet": ("magnet", ", opposite: {line: BACK, pulse_s: 0.1, pause_s: 0.4}"),
    "gripper": ("gripper", ", open_bit: opened"),
}


def described(folder: Path, kind: str, air: str = AIR) -> Path:
    name, keys = KINDS[kind]
    path = folder / "tool.yaml"
    path.write_text(TOOL.format(kind=name, keys=keys, air=air))
    return path


@pytest.mark.parametrize("kind", KINDS)
def test_a_release_blows_and_nothing_is_refused(kind: str, tmp_path: Path) -> None:
    tool = ready(load_tool(described(tmp_path, kind)))
    assert tool.command("grip").accepted
    until(tool, GRIPPED)
    tool.edges.clear()
    assert tool.command("drop").accepted
    until(tool, STAND_BY)
    held = next(
        edge.at for edge in tool.edges if (edge.line, edge.level) in (("HOLD", False), ("BACK", True))
    )
    on, off = (edge.at for edge in tool.edges if edge.line == "AIR")
    assert held + 50_000 <= on
    assert 190_000 <= off - on <= 300_000
    assert not tool.latched
    assert not any(tool.levels.values())


def test_what_sticks_to_a_magnet_comes_off_by_blowing_alone(tmp_path: Path) -> None:
    for air, end in ((AIR, STAND_BY), ("", EndEffectorState.RELEASE_ERROR)):
        tool = ready(load_tool(described(tmp_path, "magnet", air)), "sticks:holder")
        assert tool.command("grip").accepted
        until(tool, GRIPPED)
        assert tool.command("drop").accepted
        until(tool, end)


def test_a_drop_right_after_the_grip_waits_for_the_pause_before_it_blows(tmp_path: Path) -> None:
    """The change back waits for the pulse and its pause: the arbiter would refuse to blow before it."""
    tool = ready(load_tool(described(tmp_path, "switched magnet")))
    assert tool.command("grip").accepted
    assert tool.run_until(tool.at + 1_000_000, lambda: any(tool.levels.values()))
    assert tool.command("cancel").accepted
    until(tool, STAND_BY)
    assert not tool.latched
    assert not any("IL-08" in alarm for status in tool.statuses for alarm in status.alarm_texts)
    back = next(edge.at for edge in tool.edges if (edge.line, edge.level) == ("BACK", True))
    on, _ = (edge.at for edge in tool.edges if edge.line == "AIR")
    assert back + 50_000 <= on


ON_A_BUS = """
schema: 2
name: cup
lines: {{backend: gpiod}}
link: {{port: /dev/ttyUSB0, baudrate: 115200, frame: {{modbus: {{}}}}, period_ms: {period}}}
channels:
  vacuum: {{modbus: {{unit: 65, address: 18}}, unit: kPa, scale: -0.1, range: [-110, 50]}}
  told: {{modbus: {{unit: 65, address: 0, bitmask: 0xFF00}}, on: [1]}}
sequence: [cup]
actuators:
  cup:
    kind: vacuum
    channel: vacuum
    modbus: {{unit: 65, address: 0, command_on: [0x0150], command_off: [0x0000], verify: told}}
    blow_off: {{line: AIR, duration_s: 0.2}}
supply: {{channel: none}}
"""


@pytest.mark.parametrize("period_ms", [20, 400])
def test_an_output_on_a_bus_is_blown_off_when_it_has_acknowledged_however_rarely_it_is_read(
    period_ms: int, tmp_path: Path
) -> None:
    path = tmp_path / "tool.yaml"
    path.write_text(ON_A_BUS.format(period=period_ms))
    tool = ready(load_tool(path))
    assert tool.command("grip").accepted
    until(tool, GRIPPED)
    tool.edges.clear()
    assert tool.command("drop").accepted
    until(tool, STAND_BY)
    assert [(edge.line, edge.level) for edge in tool.edges] == [
        ("modbus:65/0x0000", False), ("AIR", True), ("AIR", False),
    ]  # fmt: skip


@pytest.mark.parametrize("kind", first_of(KINDS))
def test_such_a_tool_is_proven(kind: str, tmp_path: Path) -> None:
    description = load_tool(described(tmp_path, kind))
    proof = prove_tool(description, network_of(description))
    assert proof.holds, [each.id for each in proof.findings if not each.holds]


@pytest.mark.parametrize("kind", KINDS)
def test_with_an_open_e_stop_nothing_is_told_to_be_blown_off(kind: str, tmp_path: Path) -> None:
    path = described(tmp_path, kind)
    stop = "  estop: {digital: {line: STOP}}\n"
    text = path.read_text().replace("sequence:", f"{stop}sequence:") + "e_stop: {channel: estop}\n"
    path.write_text(text)
    tool = ready(load_tool(path))
    assert tool.command("grip").accepted
    until(tool, GRIPPED)
    tool.choose("estop-open")
    tool.run(0.5)
    assert tool.command("drop").accepted
    tool.run(6.0)
    told = " ".join(line for status in tool.statuses for line in event_lines(tool.description, status))
    assert "blow-off of holder) is not activated: the emergency stop is open" in told
    assert "is blown off" not in told
    assert not tool.levels["AIR"]
