"""ToolChange on a transport and a tool of the test."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest

from end_effector_hal.control import Answer
from end_effector_hal.control.goals import Outcome
from end_effector_hal.nodes._services import NO_END, ToolChangeNode
from end_effector_hal.nodes.interface import ARM_TOOL_CHANGER, DIAGNOSTICS, DIAGNOSTICS_HZ
from end_effector_hal.runtime import Refused, Result
from end_effector_hal.vocabulary import ChangerState, Command, EndEffectorState
from tests.support.lone_node import LoneTool, LoneTransport, status

UNLOCK = True
STAND_BY = EndEffectorState.STAND_BY


class Rig:
    """ToolChange, and the tool that it commands."""

    def __init__(self) -> None:
        self.transport = LoneTransport()
        ToolChangeNode(cast("Any", self.transport))

    @property
    def tool(self) -> LoneTool:
        return self.transport.hal

    def set(self, active: bool) -> Answer:
        return self.transport.services["SetToolChanger"](SimpleNamespace(data=active))

    def health(self) -> tuple[int, str]:
        self.transport.ticks[DIAGNOSTICS_HZ]()
        (found,) = self.transport.published[DIAGNOSTICS.name][-1].status
        return found.level, found.message


@pytest.fixture
def rig() -> Rig:
    return Rig()


def test_what_the_sensors_show_already_is_not_commanded(rig: Rig) -> None:
    rig.tool.says(status(changer=ChangerState.LOCKED))
    said = "The tool changer is LOCKED already, proven by its sensors."
    assert rig.set(not UNLOCK) == Answer(True, said)
    assert rig.tool.asked == []


def test_an_accepted_command_ends_with_the_proof(rig: Rig) -> None:
    rig.tool.says(status(changer=ChangerState.LOCKED))
    assert rig.set(UNLOCK) == Answer(True, "The tool changer is UNLOCKED, proven by its sensors.")
    assert rig.tool.asked == [Command.UNLOCK]


@pytest.mark.parametrize(
    ("end", "decided"),
    [
        (Result(Outcome.FAILED, STAND_BY, "Neither sensor proves it."), True),
        (Refused(Outcome.REJECTED, STAND_BY, "IL-01: something is held."), True),
        (Result(Outcome.UNREACHABLE, STAND_BY, "The HAL has gone."), False),
    ],
)
def test_a_failure_is_passed_on_with_its_reason(rig: Rig, end: Result, decided: bool) -> None:
    rig.tool.ends = end
    assert rig.set(UNLOCK) == Answer(False, end.reason, decided=decided)


def test_an_end_that_is_not_seen_is_not_known(rig: Rig) -> None:
    rig.tool.ends = None
    assert rig.set(UNLOCK) == Answer(False, NO_END, decided=False)


def test_arm_is_decided_by_the_tool(rig: Rig) -> None:
    rig.tool.answer = Answer(False, "IL-02: a sensor shows the stand.")
    assert rig.transport.services[ARM_TOOL_CHANGER.name](None) == rig.tool.answer
    assert rig.tool.asked == ["arm"]


def test_its_health_is_that_of_the_tool_changer(rig: Rig) -> None:
    rig.tool.alive = False
    assert rig.health() == (1, "The HAL has not reported yet.")
    rig.tool.alive = True
    rig.tool.says(status(changer=ChangerState.LOCKED))
    assert rig.health() == (0, "As it should be.")
    rig.tool.says(status(changer=ChangerState.FAULT, changer_reason="Both bits are set."))
    assert rig.health() == (2, "Both bits are set.")
