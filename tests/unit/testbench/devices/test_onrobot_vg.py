"""The VG10, by its manual."""

from __future__ import annotations

import pytest

from end_effector_lab.testbench.devices import model_for
from end_effector_lab.testbench.physics import VacuumCircuit
from tests.unit.testbench.devices.played import PlayedUnit


class Cups(PlayedUnit):
    def __init__(self) -> None:
        model = model_for("onrobot-vg10")
        assert model is not None
        super().__init__(model, {0: VacuumCircuit(), 1: VacuumCircuit()})

    @property
    def vacuum(self) -> list[int]:
        return self.words(18, 2, function=3)


def test_each_channel_has_its_target() -> None:
    cups = Cups()
    assert cups.vacuum == [0, 0]
    assert cups.ask("06 0000 0150") == "06 00 00 01 50"
    cups.run(2)
    assert cups.vacuum == [800, 0]
    cups.write(0, 0x0150, 0x0128)
    cups.run(2)
    assert cups.vacuum == [800, 400]
    assert cups.words(0, 3, function=3) == [0x0150, 0x0128, 500]
    cups.write(0, 0, 0)
    cups.run(3)
    assert cups.vacuum == [0, 0]


def test_an_idle_pump_vents_nothing_and_no_message_is_no_matter() -> None:
    cups = Cups()
    cups.write(0, 0x0150)
    cups.run(2)
    cups.write(0, 0x0200)
    cups.run(100)
    assert cups.vacuum[0] > 800
    assert cups.told[-1] == (0, True)


@pytest.mark.parametrize(
    ("pdu", "answer"),
    [
        ("06 0000 0300", "86 03"),
        ("06 0002 03E9", "86 03"),
        ("06 0002 03E8", "06 00 02 03 E8"),
        ("06 0003 0000", "86 02"),
        ("04 0012 0002", "84 01"),
        ("03 0019 0001", "83 02"),
        ("03 0102 0002", "83 02"),
    ],
)
def test_what_it_refuses(pdu: str, answer: str) -> None:
    assert Cups().ask(pdu) == answer


def test_a_target_above_the_maximum_is_the_maximum() -> None:
    cups = Cups()
    cups.write(0, 0x01FF)
    cups.run(3)
    assert cups.vacuum[0] == 800


def test_without_power_it_lets_go() -> None:
    cups = Cups()
    cups.write(0, 0x0150, 0x0150)
    cups.run(2)
    cups.model.power_up(cups.at)
    cups.run(3)
    assert cups.vacuum == [0, 0]
