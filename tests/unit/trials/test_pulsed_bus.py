"""A bistable valve on a bus, played and judged: it stays where it is without power."""

from __future__ import annotations

from pathlib import Path

import pytest

from end_effector_hal.codecs import load_tool
from end_effector_lab.trials import case_from_words, play_case

TOOL = """
schema: 2
name: pulsed
link: {port: "tcp://192.168.1.20", period_ms: 20, frame: {modbus: {timeout_ms: 100}}}
channels:
  down: {modbus: {address: 0, register_type: discrete_input}}
  up: {modbus: {address: 1, register_type: discrete_input}}
sequence: [lift]
actuators:
  lift:
    kind: cylinder
    modbus:
      {address: 4, register_type: coil, command_on: [1, 0], command_off: [0, 1], pulse_s: 0.1, pause_s: 0.3,
       on_link_loss: keep}
    on_power_loss: keep
    channel: none
    extended_bit: down
    retracted_bit: up
supply: {channel: none}
"""


@pytest.mark.parametrize(
    "words",
    [
        "grip; wait 2; power; wait 1; grip",
        "grip; wait 0.05; kill arbiter; wait 0.5; start arbiter; wait 2; drop",
        "grip; wait 2; scenario silent-after:0; drop; wait 3; scenario nominal",
    ],
)
def test_it_is_played_without_an_objection(words: str, tmp_path: Path) -> None:
    path = tmp_path / "end_effector.yaml"
    path.write_text(TOOL)
    tool = load_tool(path)
    assert play_case(tool, case_from_words(words, tool)).failures == {}
