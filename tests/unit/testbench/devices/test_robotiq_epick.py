"""The EPick, by its public driver and by what its users found."""

from __future__ import annotations

from typing import NamedTuple

import pytest

from end_effector_lab.testbench.devices import model_for
from end_effector_lab.testbench.physics import VacuumCircuit
from tests.unit.testbench.devices.played import PlayedUnit

ACTIVATE = (0x0100, 0, 0)
GRIP, RELEASE = (0x0B00, 20, 0x1428), (0x0B00, 255, 0x1428)
"""Advanced mode, regulated; -80 kPa at most, -60 at least, within 2 s; 155 kPa above ambient."""


class Status(NamedTuple):
    act: int
    mode: int
    gto: int
    sta: int
    obj: int
    suction: int
    flt: int
    pr: int
    po: int


class Cup(PlayedUnit):
    def __init__(self, leak_l_min: float = 0.0) -> None:
        model = model_for("robotiq-epick")
        assert model is not None
        self.cup = VacuumCircuit()
        self.cup.leak(leak_l_min)
        super().__init__(model, {0: self.cup})

    @property
    def status(self) -> Status:
        first, second, third = self.words(0x07D0, 3)
        top = first >> 8
        return Status(
            top & 1,
            top >> 1 & 3,
            top >> 3 & 1,
            top >> 4 & 3,
            top >> 6,
            first & 0xFF,
            *divmod(second, 256),
            third >> 8,
        )

    def go(self, seconds: float) -> Status:
        """Let time go on with a message every 0.1 s; return the last status."""
        for _ in range(round(seconds * 10)):
            self.run(0.1)
            status = self.status
        return status

    def gripping(self, seconds: float = 2.0) -> Status:
        for row in (ACTIVATE, RELEASE, GRIP):
            self.write(0x03E8, *row)
            status = self.go(seconds)
        return status


def test_it_activates_without_a_motion() -> None:
    cup = Cup()
    assert cup.status == Status(0, 0, 0, 0, 0, 0, 0, 0, 100)
    cup.write(0x03E8, *ACTIVATE)
    assert cup.status.sta == 1
    assert cup.go(0.6).sta == 3
    assert cup.told == []


@pytest.mark.parametrize(("leak_l_min", "found", "at_most"), [(0, 2, 20), (4, 1, 40)])
def test_a_grip_tells_the_highest_from_the_lowest_vacuum(leak_l_min: float, found: int, at_most: int) -> None:
    cup = Cup(leak_l_min)
    cup.gripping()
    status = cup.go(2)
    assert status[:7] == (1, 1, 1, 3, found, 1, 0)
    assert 20 <= status.po <= at_most, "the pump stops at what was asked for"
    assert cup.told == [(0, True)]
    cup.write(0x03E8, *RELEASE)
    assert cup.go(3) == Status(1, 1, 1, 3, 3, 2, 0, 255, 100)
    assert cup.told[1:] == [(0, False)]


def test_a_release_comes_before_the_first_grip() -> None:
    cup = Cup()
    cup.write(0x03E8, *ACTIVATE)
    cup.go(1)
    cup.write(0x03E8, *GRIP)
    assert cup.go(2).po == 100
    cup.write(0x03E8, *RELEASE)
    cup.write(0x03E8, *GRIP)
    assert cup.go(2).po == 20


def test_nothing_to_grip_is_fault_6_after_the_time_out_and_a_new_command_clears_it() -> None:
    cup = Cup(200)
    assert cup.gripping(1.0)[4:7] == (0, 1, 0)
    assert cup.go(1.5)[4:7] == (3, 2, 6)
    assert not cup.cup.valve.is_open
    cup.write(0x03E8, *RELEASE)
    assert cup.go(0.1).flt == 0


def test_the_automatic_mode_has_a_time_out_of_its_own() -> None:
    cup = Cup(1000)
    cup.gripping()
    cup.write(0x03E8, 0x0900, 255, 0)
    cup.write(0x03E8, 0x0900, 20, 0)
    assert cup.go(5)[1:7] == (0, 1, 3, 0, 1, 0)


def test_a_lost_part_is_told() -> None:
    cup = Cup()
    assert cup.gripping().obj == 2
    cup.cup.lose(cup.at)
    assert cup.go(2).obj == 3


def test_silence_of_a_second_and_a_half_stops_the_pump_and_wants_an_activation() -> None:
    cup = Cup()
    cup.gripping()
    assert cup.model.due == cup.at + 1_500_000
    cup.run(1.4)
    assert cup.status[3:7] == (3, 2, 1, 0)
    cup.run(1.6)
    assert cup.told[-1] == (0, False)
    assert cup.model.due is None
    assert cup.status[3:7] == (0, 0, 0, 9)
    cup.write(0x03E8, *GRIP)
    assert cup.go(1)[3:7] == (0, 0, 0, 9)
    cup.write(0x03E8, 0, 0, 0)
    assert cup.gripping()[3:7] == (3, 2, 1, 0)


def test_power_and_a_reset_let_go() -> None:
    for reset in (lambda cup: cup.write(0x03E8, 0, 0, 0), lambda cup: cup.model.power_up(cup.at)):
        cup = Cup()
        cup.gripping()
        reset(cup)
        assert cup.go(3)[3:] == (0, 0, 0, 0, 0, 100)


def test_the_automatic_release_wants_an_activation() -> None:
    cup = Cup()
    cup.gripping()
    cup.write(0x03E8, 0x1B00)
    assert cup.status.flt == 0xB
    assert cup.go(2)[3:7] == (0, 0, 0, 0xF)
    assert cup.status.po == 100
