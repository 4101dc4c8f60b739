"""What a device says is wrong with it, in virtual time: alarm, refusal, reset, and nothing that is held goes."""

from __future__ import annotations

import pytest

from end_effector_hal.arbiter import arbiter_policy
from end_effector_hal.control import Controller, Status, network_of
from end_effector_hal.description import Description, examine_text
from end_effector_hal.sensing import Predicates
from end_effector_hal.signals import Frame, Value
from end_effector_hal.vocabulary import EndEffectorState, Evidence

TOOL = """
schema: 2
name: tool
link: {port: /dev/null, frame: {text: {}}}
channels:
  vacuum: {text: {field: 1}, unit: kPa}
  pump:
    text: {field: 2}
    alarm:
      - {code: 8, text: it is too hot}
      - {code: 9, text: it sees nothing, unproven: [cup]}
      - {code: 3, text: the part is porous, severity: warning, latches: false}
      - {code: 4, text: low voltage, latches: false}
      - {text: a fault without a name}
  door: {text: {field: 3}, alarm: The door is open.}
sequence: [cup]
actuators:
  cup: {kind: vacuum, line: GPIO5, channel: vacuum}
supply: {channel: none}
"""
STEP_US = 20_000


@pytest.fixture(scope="module")
def description() -> Description:
    examined = examine_text(TOOL, "tool.yaml")
    assert examined.description is not None, examined.lines()
    return examined.description


class Cup:
    """A controller that sees a cup with a part, and a pump that says what the test lets it say."""

    def __init__(self, description: Description) -> None:
        self.controller = Controller(description, network_of(description))
        self.predicates = Predicates(description)
        self.needed: dict[str, bool] = {}
        self.at, self.pump, self.door = 0, 0, False
        self.statuses = self.controller.start({"GPIO5": False}, 0)
        self.run(0.5)

    @property
    def status(self) -> Status:
        return self.controller.status()

    def run(self, seconds: float, *, without: str = "") -> None:
        for _ in range(round(seconds * 1e6) // STEP_US):
            self.at += STEP_US
            grips = self.status.outputs[0]
            values: dict[str, Value] = {
                "vacuum": -80_000 if grips else 0,
                "pump": self.pump,
                "door": self.door,
            }
            values.pop(without, None)
            frame = Frame(self.at, None, None, values)
            self.needed = self.predicates.frame(frame)
            self.statuses += self.controller.frame(frame)
            self.statuses += self.controller.advance(self.at)

    def says(self, code: int) -> None:
        """The pump does, for a frame."""
        self.pump = code
        self.run(0.02)

    def grip(self) -> str:
        answer, statuses = self.controller.command("grip", self.at)
        self.statuses += statuses
        return answer.reason

    def acknowledge(self) -> None:
        self.statuses += self.controller.acknowledge(self.at)


@pytest.fixture
def cup(description: Description) -> Cup:
    return Cup(description)


@pytest.fixture
def gripped(cup: Cup) -> Cup:
    assert cup.grip() == ""
    cup.run(0.5)
    assert cup.status.ee == EndEffectorState.GRIPPED
    return cup


def test_a_code_is_an_alarm_in_its_words_and_refuses_a_grip(cup: Cup) -> None:
    assert cup.status.alarm_texts == ()
    cup.says(8)
    assert cup.status.alarm_texts == ("Pump: it is too hot.",)
    assert cup.controller.blocking["IL-07"] == cup.controller.refusal("grip") == "IL-07: Pump: it is too hot."
    assert cup.grip() == "IL-07: Pump: it is too hot."
    assert cup.status.ee == EndEffectorState.STAND_BY


def test_a_latched_fault_that_is_over_refuses_until_it_is_acknowledged(cup: Cup) -> None:
    cup.says(8)
    cup.acknowledge()
    assert cup.status.alarm_texts == ("Pump: it is too hot.",)
    cup.says(0)
    assert cup.status.alarm_texts == ("Over: Pump: it is too hot.",)
    assert cup.grip() == "IL-07: Over: Pump: it is too hot. Reset it first."
    cup.acknowledge()
    assert cup.status.alarm_texts == ()
    assert cup.grip() == ""


def test_a_code_without_a_text_of_its_own_has_that_of_all_others_and_its_number(cup: Cup) -> None:
    cup.says(13)
    assert cup.status.alarm_texts == ("Pump: a fault without a name, code 13.",)


def test_one_code_after_another_leaves_both(cup: Cup) -> None:
    cup.says(8)
    cup.says(13)
    assert cup.status.alarm_texts == ("Over: Pump: it is too hot.", "Pump: a fault without a name, code 13.")


def test_a_warning_refuses_nothing_and_one_that_does_not_latch_goes_by_itself(cup: Cup) -> None:
    cup.says(3)
    assert cup.status.alarm_texts == ("Pump: the part is porous.",)
    assert cup.grip() == ""
    cup.says(0)
    assert cup.status.alarm_texts == ()


def test_an_error_that_does_not_latch_refuses_while_it_stands(cup: Cup) -> None:
    cup.says(4)
    assert cup.grip() == "IL-07: Pump: low voltage."
    cup.says(0)
    assert cup.grip() == ""


def test_a_bit_is_an_alarm(cup: Cup) -> None:
    cup.door = True
    cup.run(0.02)
    assert cup.status.alarm_texts == ("Door: The door is open.",)
    assert cup.grip() == "IL-07: Door: The door is open."


@pytest.mark.parametrize("code", [4, 8, 9, 13])
def test_no_fault_lets_go_of_what_is_held_and_a_drop_leaves_the_alarm(gripped: Cup, code: int) -> None:
    gripped.pump = code
    gripped.run(2.0)
    assert gripped.status.ee == EndEffectorState.GRIPPED
    assert gripped.status.outputs == (True,)
    gripped.pump = 0
    gripped.run(0.5)
    answer, _ = gripped.controller.command("drop", gripped.at)
    assert answer.accepted
    gripped.run(1.0)
    assert gripped.status.ee == EndEffectorState.STAND_BY
    assert any(each.startswith("Over: Pump") for each in gripped.status.alarm_texts) is (code != 4)


def test_sensors_that_a_fault_makes_worthless_prove_nothing_while_it_stands(gripped: Cup) -> None:
    gripped.says(9)
    assert gripped.status.evidence == (Evidence.UNKNOWN,)
    assert not gripped.status.lift_allowed
    gripped.pump = 8
    gripped.run(0.2)
    assert gripped.status.evidence == (Evidence.CONFIRMED,)


def test_a_fault_while_gripping_is_no_confirmation_and_the_grip_ends_by_its_time_outs(cup: Cup) -> None:
    assert cup.grip() == ""
    cup.pump = 9
    cup.run(30.0)
    assert EndEffectorState.GRIPPED not in [each.ee for each in cup.statuses]
    assert cup.status.outputs == (False,)


def test_a_channel_without_a_reading_refuses_and_ends_no_alarm(cup: Cup) -> None:
    cup.says(8)
    cup.run(1.0, without="pump")
    assert "Pump: it is too hot." in cup.status.alarm_texts
    assert cup.status.evidence == (Evidence.UNKNOWN,)
    cup.pump = 0
    cup.run(0.1)
    cup.acknowledge()
    cup.run(0.5, without="door")
    assert (
        "door has no valid reading: its fault status is unknown; check the link."
        in cup.controller.blocking["IL-07"]
    )
    assert cup.grip() == "IL-07: door has no valid reading: its fault status is unknown; check the link."


def test_another_controller_that_goes_on_from_a_snapshot_knows_the_latched_fault(
    description: Description, cup: Cup
) -> None:
    cup.says(8)
    cup.says(0)
    snapshot = cup.controller.snapshot()
    assert snapshot is not None
    again = Controller(description, network_of(description))
    again.resume(snapshot)
    assert again.status().alarm_texts == ("Over: Pump: it is too hot.",)
    assert again.refusal("grip") == "IL-07: Over: Pump: it is too hot. Reset it first."


def test_the_arbiter_is_told_of_errors_only_and_of_what_is_read_only(
    description: Description, cup: Cup
) -> None:
    asked = {need.predicate for needs in arbiter_policy(description).needs.values() for need in needs}
    assert asked == {"no_fault:pump", "no_latching_fault:pump", "no_latching_fault:door"}
    assert cup.needed == dict.fromkeys(asked, True)
    for code, bad in ((8, {"no_latching_fault:pump"}), (4, {"no_fault:pump"}), (3, set())):
        cup.says(code)
        assert {name for name, holds in cup.needed.items() if not holds} == bad
    cup.run(1.0, without="pump")
    assert cup.needed == {"no_latching_fault:door": True}


def test_codes_without_a_text_of_their_own_are_one_alarm_however_many_come(cup: Cup) -> None:
    for code in range(100, 400):
        cup.says(code)
    assert cup.status.alarm_texts == ("Pump: a fault without a name, code 100.",)
    cup.pump = 8
    cup.run(0.1)
    assert cup.status.alarm_texts == ("Over: Pump: a fault without a name.", "Pump: it is too hot.")
