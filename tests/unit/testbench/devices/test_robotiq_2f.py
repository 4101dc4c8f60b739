"""The 2F-85, its bigger brother and the Hand-E, by what their manuals say."""

from __future__ import annotations

from typing import NamedTuple

import pytest

from end_effector_lab.testbench.devices import UnitModel, model_for
from end_effector_lab.testbench.physics import Fingers
from tests.unit.testbench.devices.played import PlayedUnit

ACTIVATE, CLOSE, OPEN = (0x0100, 0, 0), (0x0900, 0x00FF, 0xFFFF), (0x0900, 0, 0xFFFF)
CLOSE_PDU, STATUS_PDU = "10 03E8 0003 06 0900 00FF FFFF", "04 07D0 0003"


class Status(NamedTuple):
    act: int
    gto: int
    sta: int
    obj: int
    flt: int
    pr: int
    po: int
    cu: int


def model(name: str = "robotiq-2f85") -> type[UnitModel]:
    found = model_for(name)
    assert found is not None
    return found


class Gripper(PlayedUnit):
    def __init__(self, name: str = "robotiq-2f85", *, part: bool = True) -> None:
        self.fingers = Fingers()
        self.fingers.meet(part)
        super().__init__(model(name), {0: self.fingers})

    @property
    def status(self) -> Status:
        first, second, third = self.words(0x07D0, 3)
        top = first >> 8
        assert not first & 0xFF
        return Status(
            top & 1, top >> 3 & 1, top >> 4 & 3, top >> 6, second >> 8, second & 0xFF, *divmod(third, 256)
        )

    def until(self, done: str, value: int, limit_s: float = 10.0) -> float:
        """Let time go on until a field of the status has a value; return how long that took, s."""
        began = self.at
        while getattr(self.status, done) != value:
            assert self.at - began < limit_s * 1e6, self.status
            self.run(0.01)
        return (self.at - began) / 1e6

    def activated(self) -> Gripper:
        self.write(0x03E8, *ACTIVATE)
        self.until("sta", 3)
        return self

    def holding(self) -> Gripper:
        self.activated().write(0x03E8, *CLOSE)
        self.until("obj", 2)
        return self


def test_the_examples_of_the_manual() -> None:
    """Section 6 of the manual of the 2F-85 and 2F-140 has the bytes of an activation, a grip and a release."""
    gripper = Gripper()
    assert gripper.ask("10 03E8 0003 06 0000 0000 0000") == "10 03 E8 00 03"
    assert gripper.ask("10 03E8 0003 06 0100 0000 0000") == "10 03 E8 00 03"
    assert gripper.ask("04 07D0 0001") == "04 02 11 00"
    assert gripper.ask("03 07D0 0001") == "03 02 11 00", "older manuals read with function 3"
    gripper.run(4)
    assert gripper.ask("04 07D0 0001") == "04 02 31 00"
    assert gripper.ask(CLOSE_PDU) == "10 03 E8 00 03"
    assert gripper.ask(STATUS_PDU) == "04 06 39 00 00 FF 03 0A"
    gripper.run(0.9)
    assert gripper.ask(STATUS_PDU) == "04 06 B9 00 00 FF 8B 00"
    assert gripper.ask("10 03E8 0003 06 0900 0000 FFFF") == "10 03 E8 00 03"
    gripper.run(0.9)
    assert gripper.ask(STATUS_PDU) == "04 06 F9 00 00 00 03 00"


def test_after_power_up_nothing_is_known_or_moves() -> None:
    gripper = Gripper()
    gripper.run(0.5)
    assert gripper.status == Status(0, 0, 0, 0, 0, 0, 3, 0)
    assert gripper.told == []


def test_the_rising_edge_of_ract_closes_and_opens_the_fingers() -> None:
    gripper = Gripper(part=False)
    gripper.write(0x03E8, *ACTIVATE)
    positions = []
    while (status := gripper.status).sta != 3:
        assert (status.sta, status.gto, status.flt) == (1, 0, 0)
        positions.append(status.po)
        gripper.run(0.01)
    top = positions.index(230)
    assert positions[: top + 1] == sorted(positions[: top + 1])
    assert positions[top:] == sorted(positions[top:], reverse=True)
    assert gripper.status.po == 3


def test_a_part_falls_in_the_stroke_of_an_activation() -> None:
    gripper = Gripper().holding()
    gripper.write(0x03E8, 0, 0, 0)
    gripper.run(1)
    assert gripper.fingers.grips, "a reset moves nothing"
    assert gripper.told[-1] == (0, True)
    gripper.write(0x03E8, *OPEN)  # a release, which has rACT set
    gripper.run(0.2)
    assert gripper.told[-1] == (0, False)
    assert not gripper.fingers.grips
    assert gripper.status.sta == 1


def test_a_command_before_the_activation_is_fault_7() -> None:
    gripper = Gripper()
    gripper.write(0x03E8, 0x0800, 0x00FF, 0xFFFF)
    gripper.run(0.5)
    assert gripper.status._replace(pr=0) == Status(0, 0, 0, 0, 7, 0, 3, 0)


def test_a_command_during_the_activation_is_fault_5_and_done_afterwards() -> None:
    gripper = Gripper()
    gripper.write(0x03E8, *ACTIVATE)
    gripper.run(0.1)
    gripper.write(0x03E8, *CLOSE)
    assert gripper.status.flt == 5
    assert gripper.status.gto == 0
    gripper.until("sta", 3)
    assert gripper.status.flt == 0
    gripper.until("obj", 2)


@pytest.mark.parametrize("position", [60, 100, 130])
def test_any_position_at_the_commanded_speed(position: int) -> None:
    took = []
    for speed in (0, 255):
        gripper = Gripper().activated()
        gripper.write(0x03E8, 0x0900, position, speed << 8 | 0xFF)
        took.append(gripper.until("obj", 3))
        assert gripper.status.po == position
        assert gripper.status.pr == position
    way = (position - 3) / 227 * 85
    assert took[0] == pytest.approx(way / 20, abs=0.05)
    assert took[1] == pytest.approx(way / 150, abs=0.05)


@pytest.mark.parametrize(
    ("name", "fast_s"),
    [("robotiq-2f85", 85 / 150), ("robotiq-2f140", 140 / 250), ("robotiq-hand-e", 50 / 150)],
)
def test_a_whole_stroke_at_full_speed(name: str, fast_s: float) -> None:
    gripper = Gripper(name, part=False).activated()
    gripper.write(0x03E8, *CLOSE)
    assert gripper.until("obj", 3) == pytest.approx(fast_s, abs=0.06)
    assert gripper.status.po == 230


def test_closed_on_nothing_is_at_the_position() -> None:
    gripper = Gripper(part=False).activated()
    gripper.write(0x03E8, *CLOSE)
    gripper.until("po", 230)
    assert gripper.status.obj == 3


def test_a_part_that_is_lost_lets_the_fingers_go_on() -> None:
    gripper = Gripper().holding()
    gripper.fingers.lose(gripper.at)
    gripper.run(0.02)
    assert gripper.status.obj == 0
    gripper.run(1)
    assert gripper.status == Status(1, 1, 3, 3, 0, 255, 230, 0)


def test_rgto_stops_where_it_is() -> None:
    gripper = Gripper().activated()
    gripper.write(0x03E8, 0x0900, 0x00FF, 0x00FF)
    gripper.run(0.5)
    gripper.write(0x03E8, 0x0100)  # one register alone
    here = gripper.status.po
    gripper.run(1)
    assert gripper.status.po == here
    assert 3 < here < 100
    assert gripper.status.obj == 0, "not valid without rGTO"
    gripper.write(0x03E8, 0x0900)
    gripper.until("obj", 2)


def test_what_stops_the_fingers_before_their_position_while_they_open() -> None:
    gripper = Gripper().holding()
    gripper.devices[0].valve.delay_us = 10**9  # they are stuck
    gripper.write(0x03E8, *OPEN)
    gripper.fingers.valve.switches_at = None
    gripper.run(0.5)
    assert gripper.status.obj == 1
    assert gripper.fingers.grips


@pytest.mark.parametrize(("direction", "end"), [(0x20, 3), (0, 139)])
def test_the_automatic_release_wants_a_new_activation(direction: int, end: int) -> None:
    gripper = Gripper().holding()
    gripper.write(0x03E8, (0x19 | direction) << 8)
    if direction:
        assert gripper.status.flt == 0xB
        assert gripper.status.gto == 0
        assert gripper.until("flt", 0xF) > 2, "slowly"
    gripper.run(0.1)
    assert gripper.status[:5] == (1, 0, 0, 0, 0xF)
    assert gripper.status.po == end
    gripper.write(0x03E8, *CLOSE)
    gripper.run(1)
    assert gripper.status[:5] == (1, 0, 0, 0, 0xF), "it obeys nothing"
    gripper.write(0x03E8, 0, 0, 0)
    assert gripper.status.flt == 0
    gripper.activated()


def test_without_a_message_for_a_second_it_is_fault_9_and_goes_on() -> None:
    gripper = Gripper().holding()
    gripper.run(0.9)
    assert gripper.status.flt == 0
    gripper.run(1.1)
    assert gripper.status[:5] == (1, 1, 3, 2, 9)
    assert gripper.status.flt == 0
    assert gripper.fingers.grips


def test_power_that_is_lost_and_returns() -> None:
    gripper = Gripper().activated()
    gripper.write(0x03E8, 0x0900, 0x00FF, 0x00FF)
    gripper.run(0.5)
    here = gripper.status.po
    gripper.model.power_up(gripper.at)
    gripper.run(1)
    assert gripper.status._replace(flt=0) == Status(0, 0, 0, 0, 0, 0, here, 0), "the motor is off"


def test_a_fault_of_the_scenario_is_shown_and_a_major_one_lasts_until_the_reset() -> None:
    gripper = Gripper().holding()
    gripper.model.alarm = 8
    assert gripper.status[:5] == (1, 1, 3, 2, 8)
    gripper.model.alarm = 0xE
    gripper.run(0.1)
    gripper.model.alarm = 0
    assert gripper.status.flt == 0xE
    gripper.write(0x03E8, 0, 0, 0)
    assert gripper.status.flt == 0


def test_functions_addresses_and_values_that_it_has_not() -> None:
    gripper = Gripper().activated()
    assert gripper.ask("01 0000 0001") == "81 01"
    assert gripper.ask("05 0000 FF00") == "85 01"
    assert gripper.ask("16 03E8 FFFF 0000") == "96 01"
    assert gripper.ask("2B 0E 01 00") == "AB 01"
    assert gripper.ask("04 07D0 0004") == "84 02"
    assert gripper.ask("03 03E8 0001") == "83 02"
    assert gripper.ask("04 07D0 0000") == "84 03"
    assert gripper.ask("10 03E9 0003 06 0000 0000 0000") == "90 02"
    assert gripper.ask("10 03E8 0003 04 0900 00FF") == "90 03"
    assert gripper.ask("06 03E9 00FF") == "06 03 E9 00 FF"
    assert gripper.status.pr == 0xFF


def test_one_request_writes_and_reads() -> None:
    gripper = Gripper().activated()
    answer = gripper.ask("17 07D0 0002 03E8 0003 06 0900 00FF FFFF")
    assert answer == "17 04 39 00 00 FF"
    assert gripper.ask("17 07D0 0009 03E8 0003 06 0900 0000 FFFF") == "97 02"
    assert gripper.status.pr == 0xFF, "a wrong request writes nothing"
