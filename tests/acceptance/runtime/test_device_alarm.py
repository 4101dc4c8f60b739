"""A device that says it has a fault, with real processes: the testbench, the line arbiter, a program."""

from __future__ import annotations

from pathlib import Path

import pytest

from end_effector_hal.description import examine_text
from end_effector_hal.runtime import EndEffector
from end_effector_hal.vocabulary import Command
from end_effector_lab.demo._world import World
from tests.support.patience import wait_until
from tests.unit.control.test_device_faults import TOOL

pytestmark = [pytest.mark.wall, pytest.mark.timeout(120)]


def test_a_code_and_an_input_of_the_board_are_alarms_in_words_and_refuse_a_grip(tmp_path: Path) -> None:
    text = TOOL.replace("text: {field: 3}", "digital: {line: GPIO7}")
    tool = examine_text(text, "tool.yaml").description
    assert tool is not None
    described = tool.with_virtual(tmp_path / "chip", str(tmp_path / "uart"))
    with (
        World(described, "alarm:pump:8,alarm:door", tmp_path) as world,
        EndEffector.open(world.description) as opened,
    ):
        for alarm in ("Pump: it is too hot.", "Door: The door is open."):
            wait_until(alarm, lambda alarm=alarm: alarm in opened.status.alarm_texts)
        # with the one that came first
        whys = ("IL-07: Pump: it is too hot.", "IL-07: Door: The door is open.")
        wait_until("a refusal", lambda: any(why in str(opened.begin(Command.GRIP)) for why in whys))
        wait_until("the arbiter knows", lambda: "IL-07: pump shows a fault" in opened.reset().reason)
        assert not opened.reset().accepted
