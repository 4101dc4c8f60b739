"""The tool changer as it is executed, in virtual time: IL-01, IL-02, IL-04, arm and reset."""

from __future__ import annotations

import pytest

from end_effector_hal.control import Answer, Controller, Status, network_of
from end_effector_hal.description import Description
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import ChangerFault, ChangerState

READINGS = {
    "bottom": 0, "cylinder": 0, "top": 0, "supply": 600_000, "locked": True, "unlocked": False,
    "tool_present": True, "in_stand": True, "cylinder_extended": False, "cylinder_retracted": True, "estop_ok": True,
}  # fmt: skip


class Changer:
    """The controller, frames each 20 ms, and what is given to it."""

    def __init__(self, description: Description, *, fault: bool = False, **shown: object) -> None:
        self.controller = Controller(description, network_of(description))
        self.at, self.readings = 0, {**READINGS, **shown}
        self.controller.start({}, 0, sensor_fault=fault)
        self.run(1.0)

    @property
    def status(self) -> Status:
        return self.controller.status()

    @property
    def state(self) -> ChangerState:
        return ChangerState(self.status.changer)

    def shows(self, **readings: object) -> None:
        self.readings |= readings

    def run(self, seconds: float) -> None:
        until = self.at + round(seconds * 1e6)
        while self.at < until:
            self.at += 20_000
            count = self.at // 20_000
            values = {  # a sensor that never moves is taken for a broken one
                name: value + count % 3 if type(value) is int else value
                for name, value in self.readings.items()
            }
            self.controller.frame(Frame(self.at, count, self.at // 1000, values))  # type: ignore[arg-type]
            self.controller.advance(self.at)

    def give(self, name: str) -> Answer:
        return self.controller.command(name, self.at)[0]


@pytest.fixture(scope="module")
def blind(verdin: Description) -> Description:
    """The same tool without a sensor in its stand: the codec does not carry that bit."""
    changer = verdin.tool_changer
    assert changer
    return verdin.model_copy(update={"tool_changer": changer.model_copy(update={"stand_bit": "none"})})


def test_an_unlock_with_nothing_gripped_and_the_tool_in_its_stand(verdin: Description) -> None:
    tool = Changer(verdin)
    assert tool.give("unlock").accepted
    assert tool.status.unlock_output
    tool.shows(locked=False, unlocked=True)
    tool.run(0.2)
    assert tool.state is ChangerState.UNLOCKED


@pytest.mark.parametrize(("pressure", "accepted"), [(-4_900, True), (-5_100, False)])
def test_il_01_every_vacuum_is_under_5_kpa(verdin: Description, pressure: int, accepted: bool) -> None:
    answer = Changer(verdin, bottom=pressure).give("unlock")
    assert answer.accepted is accepted
    if not accepted:
        assert answer.reason.startswith("IL-01: ")
        assert "under 5 kPa for 0.5 s" in answer.reason


@pytest.mark.parametrize(("seconds", "accepted"), [(0.48, False), (0.54, True)])
def test_il_01_for_half_a_second(verdin: Description, seconds: float, accepted: bool) -> None:
    tool = Changer(verdin, top=-6_000)
    tool.shows(top=0)
    tool.run(seconds)
    assert tool.give("unlock").accepted is accepted


@pytest.mark.parametrize(
    ("in_stand", "present", "accepted"),
    [(True, True, True), (False, True, False), (False, False, True), (None, False, False)],
)  # fmt: skip
def test_il_02_the_tool_is_in_its_stand_or_absent(
    verdin: Description, in_stand: bool | None, present: bool | None, accepted: bool
) -> None:
    answer = Changer(verdin, in_stand=in_stand, tool_present=present).give("unlock")
    assert answer.accepted is accepted
    assert accepted or answer.reason.startswith("IL-02: ")


def test_without_a_reading_of_the_tool_nothing_is_locked(verdin: Description) -> None:
    tool = Changer(verdin, tool_present=None)
    assert tool.state is ChangerState.UNKNOWN
    assert "it is UNKNOWN" in tool.give("unlock").reason


def test_locked_needs_the_tool_and_an_absent_one_refuses_a_lock(verdin: Description) -> None:
    tool = Changer(verdin, tool_present=False)
    assert tool.state is ChangerState.UNKNOWN
    assert tool.give("lock") == Answer(False, "A lock is refused: there is no tool (tool_present is off).")
    tool.shows(tool_present=True)
    tool.run(0.2)
    assert tool.state is ChangerState.LOCKED
    tool.shows(tool_present=False)
    tool.run(0.05)
    assert tool.state is ChangerState.LOCKED  # it lasts for 100 ms, as the other bits do
    tool.run(0.1)
    assert tool.state is ChangerState.UNKNOWN


def test_without_a_tool_the_changer_opens_to_take_one(verdin: Description) -> None:
    tool = Changer(verdin, tool_present=False)
    assert tool.give("unlock").accepted
    tool.shows(locked=False, unlocked=True)
    tool.run(0.2)
    assert tool.state is ChangerState.UNLOCKED
    assert tool.give("lock").accepted  # its output goes inactive, whatever the sensors show
    tool.shows(locked=True, unlocked=False)
    tool.run(0.2)
    assert tool.state is ChangerState.UNKNOWN
    assert tool.status.changer_reason == "There is no tool (tool_present is off)."
    assert tool.status.changer_fault is ChangerFault.NONE


def test_a_fault_without_a_tool_is_left_by_a_reset_alone(verdin: Description) -> None:
    tool = Changer(verdin)
    tool.shows(locked=False, unlocked=True)
    tool.run(0.2)
    assert tool.state is ChangerState.FAULT
    tool.shows(locked=True, unlocked=False, tool_present=False)
    tool.run(0.2)
    assert not tool.give("lock").accepted
    assert tool.give("reset").accepted
    assert tool.state is ChangerState.UNKNOWN


def test_without_a_sensor_of_the_stand_an_absent_tool_is_armed_too(blind: Description) -> None:
    tool = Changer(blind, tool_present=False)
    assert tool.give("arm").accepted
    assert tool.give("unlock").accepted


def test_il_02_where_no_sensor_shows_it_an_unlock_is_armed_first(blind: Description) -> None:
    tool = Changer(blind)
    assert tool.give("unlock").reason.startswith("IL-02: no sensor shows where the tool is: arm first")
    assert tool.give("arm").accepted
    assert tool.status.armed
    tool.run(9.9)
    assert tool.give("unlock").accepted
    assert not tool.status.armed


def test_il_02_what_was_armed_expires(blind: Description) -> None:
    tool = Changer(blind)
    assert tool.give("arm").accepted
    tool.run(10.02)
    assert not tool.status.armed
    assert not tool.give("unlock").accepted


def test_nothing_is_armed_where_a_sensor_shows_it(verdin: Description) -> None:
    answer = Changer(verdin).give("arm")
    assert not answer.accepted
    assert answer.reason == "A sensor (in_stand) shows where the tool is: an unlock needs no arming."


@pytest.mark.parametrize("bits", [True, False])
def test_il_04_both_bits_or_neither_are_a_fault_until_a_reset(verdin: Description, bits: bool) -> None:
    tool = Changer(verdin)
    tool.shows(locked=bits, unlocked=bits)
    tool.run(0.5)
    assert tool.state is ChangerState.LOCKED
    tool.run(0.04)
    assert (tool.state, tool.status.changer_fault) == (ChangerState.FAULT, ChangerFault.SENSOR)
    assert tool.status.changer_reason.startswith(
        "IL-04: locked and unlocked were both on, or both off, for 0.5 s"
    )
    assert not tool.give("reset").accepted, "it is still there"
    tool.shows(locked=True, unlocked=False)
    tool.run(1.0)
    assert tool.state is ChangerState.FAULT
    assert not tool.give("lock").accepted
    assert tool.give("reset").accepted
    tool.run(0.1)
    assert tool.state is ChangerState.LOCKED


def test_a_sensor_fault_survives_a_restart(verdin: Description) -> None:
    tool = Changer(verdin, fault=True)
    assert (tool.state, tool.status.changer_fault) == (ChangerState.FAULT, ChangerFault.SENSOR)
    assert tool.give("reset").accepted
    assert tool.state is ChangerState.LOCKED


def test_what_the_line_arbiter_refuses_ends_the_unlock_at_once(verdin: Description) -> None:
    tool = Changer(verdin)
    assert tool.give("unlock").accepted
    tool.controller.refused(tool.at, unlock=True)
    assert (tool.state, tool.status.unlock_output) == (ChangerState.LOCKED, False)


def test_a_lock_that_is_not_proven_in_time_is_a_fault_that_a_lock_leaves(verdin: Description) -> None:
    tool = Changer(verdin)
    tool.give("unlock")
    tool.shows(locked=False, unlocked=True)
    tool.run(0.2)
    assert tool.give("lock").accepted
    tool.run(2.1)
    assert (tool.state, tool.status.changer_fault) == (ChangerState.FAULT, ChangerFault.UNPROVEN)
    tool.shows(locked=True, unlocked=False)
    tool.run(0.2)
    assert tool.give("lock").accepted
    tool.run(0.1)
    assert tool.state is ChangerState.LOCKED
