"""Outputs on a bus that cannot be read back: another line arbiter does not know how they stand, the program does."""

from __future__ import annotations

from pathlib import Path

import pytest

from end_effector_hal.codecs import load_tool
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_lab.virtual import VirtualTool

TOOL = """
schema: 2
name: two_cups
link: {port: /dev/ttyUSB0, baudrate: 115200, period_ms: 100, frame: {modbus: {}}}
channels:
  vac_a: {modbus: {unit: 65, address: 18}, unit: Pa, scale: -101.325, range: [-101325, 0]}
  vac_b: {modbus: {unit: 65, address: 19}, unit: Pa, scale: -101.325, range: [-101325, 0]}
sequence: [cup_a, cup_b]
actuators:
  cup_a:
    kind: vacuum
    modbus: {unit: 65, address: 0, command_on: [0x0150], command_off: [0], on_link_loss: hold}
    channel: vac_a
  cup_b:
    kind: vacuum
    modbus: {unit: 65, address: 1, command_on: [0x0150], command_off: [0], on_link_loss: hold}
    channel: vac_b
supply: {channel: none}
"""
GRIP_ERROR, GRIPPED, STAND_BY = (
    EndEffectorState.GRIP_ERROR,
    EndEffectorState.GRIPPED,
    EndEffectorState.STAND_BY,
)


def until(tool: VirtualTool, state: EndEffectorState) -> None:
    assert tool.run_until(tool.at + 20_000_000, lambda: tool.status.ee == state), tool.status


@pytest.mark.parametrize(("scenario", "ends"), [("nominal", GRIPPED), ("shows:cup_b:0", GRIP_ERROR)])
def test_another_arbiter_and_a_sensor_that_lies_drop_nothing(
    tmp_path: Path, scenario: str, ends: EndEffectorState
) -> None:
    path = tmp_path / "end_effector.yaml"
    path.write_text(TOOL)
    tool = VirtualTool(load_tool(path))
    until(tool, STAND_BY)
    tool.run(1.0)
    assert tool.command("grip").accepted
    until(tool, GRIPPED)
    before = list(tool.edges)
    tool.kill("arbiter")
    tool.run(2.0)
    tool.start("arbiter")
    tool.run(0.02)
    tool.choose(scenario)
    tool.run(6.0)
    assert any("was unknown" in status.reason for status in tool.statuses), "it has adopted again"
    assert tool.edges == before
    assert tool.status.ee == ends
    assert tool.status.outputs == (True, True)
    tool.choose("nominal")
    tool.run(1.0)
    assert tool.command("drop").accepted
    until(tool, STAND_BY)
    assert [(edge.line, edge.level) for edge in tool.edges[len(before) :]] == [
        (before[1].line, False),
        (before[0].line, False),
    ]
