"""A station of remote inputs and outputs: all functions of the standard."""

from __future__ import annotations

import pytest

from end_effector_lab.testbench.devices import model_for
from end_effector_lab.testbench.physics import Fingers
from tests.unit.testbench.devices.played import PlayedUnit


def played(name: str) -> PlayedUnit:
    model = model_for(name)
    assert model is not None
    return PlayedUnit(model, {3: Fingers()})


@pytest.fixture
def station() -> PlayedUnit:
    return played("remote-io")


def test_coils_drive_what_hangs_on_them_and_are_read_back(station: PlayedUnit) -> None:
    assert station.ask("05 0003 FF00") == "05 00 03 FF 00"
    station.run(1)
    assert station.devices[3].grips
    assert station.ask("0F 0000 000A 02 05 02") == "0F 00 00 00 0A"
    assert station.ask("01 0000 000A") == "01 02 05 02"
    assert station.told[0] == (3, True)
    assert (3, False) in station.told
    station.run(1)
    assert not station.devices[3].grips


def test_registers_are_written_masked_and_exchanged(station: PlayedUnit) -> None:
    assert station.ask("06 0004 0012") == "06 00 04 00 12"
    assert station.ask("16 0004 00F2 0025") == "16 00 04 00 F2 00 25"
    assert station.words(4, 1, function=3) == [0x0017], "the example of the standard"
    assert station.ask("17 0004 0002 0005 0001 02 ABCD") == "17 04 00 17 AB CD"


def test_inputs_show_what_is_wired_to_them_and_outlive_a_restart(station: PlayedUnit) -> None:
    station.model.wire(2, 8, [1, 0, 1])
    station.model.wire(4, 1, [0xBEEF])
    station.ask("05 0003 FF00")
    station.model.power_up(station.at)
    assert station.ask("02 0008 0003") == "02 01 05"
    assert station.words(0, 2) == [0, 0xBEEF]
    assert station.ask("01 0003 0001") == "01 01 00"
    assert station.told == [(3, True), (3, False)]


@pytest.mark.parametrize(
    ("pdu", "answer"),
    [
        ("07", "87 01"),
        ("03 01FF 0002", "83 02"),
        ("0F 01FF 0002 01 03", "8F 02"),
        ("01 0000 07D1", "81 03"),
        ("03 0000 007E", "83 03"),
        ("05 0000 0001", "85 03"),
        ("10 0000 0000 00", "90 03"),
        ("10 0000 0002 02 0001", "90 03"),
        ("06 0000", "86 03"),
    ],
)
def test_exceptions(station: PlayedUnit, pdu: str, answer: str) -> None:
    assert station.ask(pdu) == answer
    assert station.told == []


def test_a_wago_reads_its_outputs_at_another_place() -> None:
    station = played("wago-750")
    assert station.ask("05 0003 FF00") == "05 00 03 FF 00"
    assert station.ask("01 0200 0010") == "01 02 08 00"
    assert station.ask("05 0010 FF00") == "85 02"
    assert station.ask("01 020F 0002") == "81 02"


def test_an_adam_has_twelve_coils() -> None:
    station = played("advantech-adam-4056so")
    assert station.ask("0F 0010 000C 02 FF 0F") == "0F 00 10 00 0C"
    assert station.ask("01 0010 000C") == "01 02 FF 0F"
    assert station.ask("05 000F FF00") == "85 02"
    assert station.ask("05 001C FF00") == "85 02"
    assert station.ask("02 0000 0001") == "82 01"
