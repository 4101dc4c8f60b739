"""A tool whose device sends lines of JSON, with words, when it is asked; its lines have no names."""

from __future__ import annotations

from pathlib import Path

import pytest

from end_effector_hal.codecs import load_tool
from end_effector_hal.description import Description
from end_effector_hal.vocabulary import EndEffectorState, Evidence
from end_effector_lab.virtual import VirtualTool

ASKED = """\
schema: 2
name: asked
link: {port: /dev/ttyUSB0, baudrate: 9600, period_ms: 40, frame: {json: {ask: "READ\\r"}}}
channels:
  cup: {json: {key: cups.0.vacuum}, unit: mmHg, range: [-790, 150]}
  part: {json: {key: part}, on: ["ON", true]}
  jaw_open: {json: {key: jaw.state}, on: [OPEN], off: [BETWEEN, SHUT]}
  jaw_shut: {json: {key: jaw.state}, on: [SHUT], off: [BETWEEN, OPEN]}
sequence: [cups, jaw]
actuators:
  cups: {kind: vacuum, line: {chip: gpiochip3, offset: 4}, channel: cup}
  jaw:
    kind: gripper
    line: {chip: gpiochip3, offset: 5}
    part_bit: part
    open_bit: jaw_open
    closed_bit: jaw_shut
supply: {channel: none}
"""


@pytest.fixture
def asked(tmp_path: Path) -> Description:
    (tmp_path / "tool.yaml").write_text(ASKED)
    return load_tool(tmp_path / "tool.yaml")


def until(tool: VirtualTool, state: EndEffectorState, seconds: float = 60.0) -> None:
    reached = tool.run_until(tool.at + round(seconds * 1e6), lambda: tool.status.ee == state)
    assert reached, f"{tool.status.ee.name}: {tool.status.reason} {tool.status.alarm_texts}"


def test_it_grips_and_drops(asked: Description) -> None:
    tool = VirtualTool(asked)
    until(tool, EndEffectorState.STAND_BY)
    assert tool.command("grip").accepted
    until(tool, EndEffectorState.GRIPPED)
    assert [(edge.line, edge.level) for edge in tool.edges] == [("gpiochip3:4", True), ("gpiochip3:5", True)]
    assert tool.command("drop").accepted
    until(tool, EndEffectorState.STAND_BY)
    assert not any(tool.levels.values())


def test_nothing_is_known_of_a_device_that_does_not_answer_and_the_part_stays_held(
    asked: Description,
) -> None:
    tool = VirtualTool(asked)
    until(tool, EndEffectorState.STAND_BY)
    assert tool.command("grip").accepted
    until(tool, EndEffectorState.GRIPPED)
    tool.choose("no-answers:1")
    tool.run(3.0)
    assert set(tool.status.evidence) == {Evidence.UNKNOWN}
    assert all(tool.levels.values())
    tool.choose("nominal")
    tool.run(3.0)
    assert set(tool.status.evidence) == {Evidence.CONFIRMED}
    assert tool.status.ee is EndEffectorState.GRIPPED


@pytest.mark.parametrize(
    "scenario", ["late-answers:100", "noise:0.02", "lost-bytes:0.02", "twice-answers:0.5"]
)
def test_a_bad_line_holds_the_part(asked: Description, scenario: str) -> None:
    tool = VirtualTool(asked)
    until(tool, EndEffectorState.STAND_BY)
    assert tool.command("grip").accepted
    until(tool, EndEffectorState.GRIPPED)
    tool.choose(scenario)
    tool.run(20.0)
    assert tool.status.ee is EndEffectorState.GRIPPED, tool.status.reason
    assert all(tool.levels.values())
