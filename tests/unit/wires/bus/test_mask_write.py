"""Bits of a register that are written alone, with function 22: their neighbours stay as they are, known or not."""

from __future__ import annotations

import pytest

from end_effector_hal.codecs.modbus import RegisterWrite, acknowledgement, write_request
from end_effector_lab.testbench import CommandedRegisters
from tests.unit.wires.bus.played_bus import Bus, Registers, S, described
from tests.unit.wires.bus.test_bits_of_a_register import TERMINAL, A, B

ALONE = TERMINAL.replace(", verify: a_on", ", use_mask_write: true").replace(
    ", verify: b_on", ", use_mask_write: true"
)


def test_the_request_is_that_of_the_standard() -> None:
    """MODBUS Application Protocol Specification V1.1b3, 6.16: its example for function 0x16."""
    write = RegisterWrite(1, 4, (0x25,), mask=0xFFFF & ~0xF2)
    assert write_request(write)[:-2] == bytes.fromhex("01 16 0004 00F2 0025")
    assert acknowledgement(write) == write_request(write)


class Station(Registers):
    """A device that has function 22, whose two values are what is kept and what is set."""

    def write(self, address: int, values: tuple[int, ...], at: int) -> bool:
        keeps, sets = values
        self.words[address] = (self.words[address] & keeps) | (sets & ~keeps)
        return True


@pytest.fixture
def station() -> Station:
    return Station()


@pytest.fixture
def bus(station: Station) -> Bus:
    return Bus(described(ALONE), {1: station})


def test_each_output_keeps_the_bits_that_nobody_knows(bus: Bus, station: Station) -> None:
    station.words[5] = 0xF0F1
    bus.to(1 * S)
    for levels, word in (
        ({A: True}, 0xF0F5),
        ({B: True}, 0xF3F5),
        ({A: False}, 0xF3F1),
        ({B: False}, 0xF0F1),
    ):
        bus.outputs.command(levels, bus.at)
        bus.to(bus.at + 1 * S)
        assert station.words[5] == word
    assert bus.outputs.known(bus.at) == {A: False, B: False}
    assert not bus.outputs.troubles(bus.at)
    assert [request[1] for request in bus.requests if request[1] != 3] == [22] * 4


def test_the_testbench_switches_only_what_the_mask_names() -> None:
    switched: list[tuple[str, bool]] = []
    tool = described(ALONE)
    devices = CommandedRegisters(tool.register_outputs, lambda name, level: switched.append((name, level)))
    devices.start({B: True}, 0)
    for level, bits in ((True, 0x0004), (False, 0)):
        request = write_request(RegisterWrite(1, 5, (bits,), mask=0x0004))
        assert devices.answer(request) == request
        assert switched[-1] == (A, level)
    assert len(switched) == 2
