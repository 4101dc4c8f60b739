"""The RG2, by public drivers."""

from __future__ import annotations

from pathlib import Path

import pytest

from end_effector_hal.codecs import load_tool
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_lab.testbench.devices import model_for
from end_effector_lab.testbench.physics import Fingers
from end_effector_lab.virtual import VirtualTool
from tests.unit.testbench.devices.played import PlayedUnit
from tests.unit.testbench.devices.test_schunk_egu import TOOL
from tests.unit.virtual.test_unread_outputs import until

CLOSE, OPEN = (200, 0, 1), (200, 1100, 1)


class Hand(PlayedUnit):
    def __init__(self) -> None:
        model = model_for("onrobot-rg2")
        assert model is not None
        super().__init__(model, {0: Fingers()})

    @property
    def shown(self) -> list[int]:
        """Width and status."""
        return self.words(0x010B, 2, function=3)


def test_a_grip_and_any_width() -> None:
    hand = Hand()
    assert hand.shown == [1100, 0]
    hand.write(0, *CLOSE)
    assert hand.shown[1] == 1, "busy"
    hand.run(2)
    assert hand.shown == [440, 2]
    hand.write(0, 200, 900, 1)
    hand.run(2)
    assert hand.shown == [900, 0]
    assert hand.told == [(0, True), (0, False)]


def test_a_command_while_it_is_busy_is_ignored() -> None:
    hand = Hand()
    hand.write(0, *CLOSE)
    hand.run(0.1)
    hand.write(0, *OPEN)
    hand.run(2)
    assert hand.shown == [440, 2]
    hand.write(0, *OPEN)
    hand.run(2)
    assert hand.shown == [1100, 0]


def test_after_a_safety_switch_it_moves_only_when_its_power_was_off() -> None:
    hand = Hand()
    hand.model.alarm = 1
    hand.run(0.1)
    hand.model.alarm = 0
    hand.write(0, *CLOSE)
    hand.run(2)
    assert hand.shown == [1100, 8]
    hand.model.power_up(hand.at)
    hand.write(0, *CLOSE)
    hand.run(2)
    assert hand.shown == [440, 2]


@pytest.mark.parametrize(
    ("pdu", "answer"), [("04 010B 0001", "84 01"), ("03 0108 0001", "83 02"), ("06 0001 044D", "86 03")]
)
def test_what_it_refuses(pdu: str, answer: str) -> None:
    assert Hand().ask(pdu) == answer


def test_a_cancel_that_it_ignores_while_it_closes_is_told_and_a_drop_opens_it(tmp_path: Path) -> None:
    path = tmp_path / "end_effector.yaml"
    path.write_text(TOOL.replace("schunk-egu", "onrobot-rg2"))
    tool = VirtualTool(load_tool(path))
    tool.run(3.0)
    assert tool.command("grip").accepted
    tool.run(0.25)
    assert tool.command("cancel").accepted
    until(tool, EndEffectorState.RELEASE_ERROR)
    assert tool.command("drop").accepted
    until(tool, EndEffectorState.STAND_BY)
    assert tool.command("grip").accepted
    until(tool, EndEffectorState.GRIPPED)
