"""ToolChange on a transport of the test: Grip answers, and publishes, what a test says."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest

from end_effector_hal.control import Answer
from end_effector_hal.nodes import _tool_change
from end_effector_hal.nodes._tool_change import NO_END, ToolChangeNode
from end_effector_hal.nodes.interface import ARM, ARM_TOOL_CHANGER, DIAGNOSTICS, DIAGNOSTICS_HZ, GRIP_STATE
from end_effector_hal.nodes.transport import StatusMessage
from end_effector_hal.vocabulary import ChangerState, Command
from end_effector_hal.wires import now_us
from tests.support.lone_node import LoneTransport

UNLOCK = True


class Rig:
    """ToolChange; ``meanwhile`` are the states that come before Grip's answer."""

    def __init__(self) -> None:
        self.transport = LoneTransport()
        ToolChangeNode(cast("Any", self.transport))
        self.transport.answers = self._answer
        self.asked: list[int] = []
        self.answer = Answer(True, count=7)
        self.meanwhile: list[StatusMessage] = []

    def _answer(self, command: int) -> Answer:
        self.asked.append(command)
        for each in self.meanwhile:
            self.says(each)
        return self.answer

    def says(self, status: StatusMessage) -> None:
        self.transport.callbacks[GRIP_STATE.name](status)

    def set(self, active: bool) -> Answer:
        return self.transport.services["SetToolChanger"](SimpleNamespace(data=active))

    def health(self) -> tuple[int, str]:
        self.transport.ticks[DIAGNOSTICS_HZ]()
        (status,) = self.transport.published[DIAGNOSTICS.name][-1].status
        return status.level, status.message


@pytest.fixture
def rig(monkeypatch: pytest.MonkeyPatch) -> Rig:
    monkeypatch.setattr(_tool_change, "MARGIN_S", -2.8)  # a bound of 0.2 s for this tool
    return Rig()


def state(count: int, changer: ChangerState, command: Command = Command.NONE, **fields: Any) -> StatusMessage:
    fields = {"since_us": 5, "at_us": now_us(), **fields}
    return StatusMessage(count=count, tool_changer=changer, command=command, **fields)


def test_what_the_sensors_show_already_is_not_commanded(rig: Rig) -> None:
    rig.says(state(1, ChangerState.LOCKED))
    said = "The tool changer is LOCKED already, proven by its sensors."
    assert rig.set(not UNLOCK) == Answer(True, said)
    assert rig.asked == []


def test_an_accepted_command_ends_with_the_state_that_proves_it(rig: Rig) -> None:
    rig.says(state(6, ChangerState.LOCKED))
    rig.meanwhile = [
        state(7, ChangerState.UNLOCKING, Command.UNLOCK),
        state(8, ChangerState.UNLOCKED),
    ]
    assert rig.set(UNLOCK) == Answer(True, "The tool changer is UNLOCKED, proven by its sensors.")
    assert rig.asked == [Command.UNLOCK]


def test_a_command_that_is_not_proven_fails_with_the_reason_of_the_tool_changer(rig: Rig) -> None:
    rig.says(state(6, ChangerState.UNLOCKED))
    why = "Neither sensor proves it."
    rig.meanwhile = [state(9, ChangerState.FAULT, changer_reason=why, reason="of gripping")]
    said = f"The tool changer is FAULT: its sensors do not prove LOCKED. {why}"
    assert rig.set(not UNLOCK) == Answer(False, said)


def test_a_refusal_is_passed_on(rig: Rig) -> None:
    rig.says(state(6, ChangerState.LOCKED))
    rig.answer = Answer(False, "IL-01: something is held.")
    assert rig.set(UNLOCK) == rig.answer


def test_nothing_is_asked_of_a_grip_that_is_silent(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    assert rig.set(UNLOCK) == Answer(False, "The node Grip has not reported yet.", decided=False)
    rig.says(state(6, ChangerState.LOCKED))
    later = now_us() + 1_100_000
    monkeypatch.setattr(_tool_change, "now_us", lambda: later)
    answer = rig.set(not UNLOCK)
    assert (answer.accepted, answer.decided) == (False, False), "what it showed last proves nothing any more"
    assert answer.reason.startswith("The node Grip is silent")
    assert rig.asked == []


@pytest.mark.parametrize(
    "meanwhile",
    [
        [],
        [state(6, ChangerState.UNLOCKED)],
        [state(7, ChangerState.UNLOCKING, Command.UNLOCK)],
        [state(9, ChangerState.UNLOCKED, since_us=6)],
    ],
    ids=["Grip says nothing more", "the state is from before", "it goes on", "Grip was started again"],
)
def test_an_end_that_is_not_seen_is_not_known(rig: Rig, meanwhile: list[StatusMessage]) -> None:
    rig.says(state(5, ChangerState.LOCKED))
    rig.meanwhile = meanwhile
    assert rig.set(UNLOCK) == Answer(False, NO_END, decided=False)


def test_a_state_of_the_future_counts_for_nothing(rig: Rig) -> None:
    rig.says(state(1, ChangerState.LOCKED, at_us=now_us() + 60_000_000))
    assert not rig.set(not UNLOCK).accepted


def test_arm_is_decided_by_grip(rig: Rig) -> None:
    rig.answer = Answer(False, "IL-02: a sensor shows the stand.")
    assert rig.transport.services[ARM_TOOL_CHANGER.name](None) == rig.answer
    assert rig.asked == [ARM]


def test_its_health_is_that_of_the_tool_changer(rig: Rig) -> None:
    assert rig.health() == (1, "The node Grip has not reported yet.")
    rig.says(state(1, ChangerState.LOCKED))
    assert rig.health() == (0, "As it should be.")
    rig.says(state(2, ChangerState.FAULT, changer_reason="Both bits are set."))
    assert rig.health() == (2, "Both bits are set.")
