"""Outputs that are bits of one register: written together by their owner, and never over what is not known."""

from __future__ import annotations

import pytest

from end_effector_hal.description import examine_text
from end_effector_lab.testbench import CommandedRegisters
from end_effector_lab.testbench.devices import sealed
from tests.unit.wires.bus.played_bus import MS, Bus, Registers, S, described, writes

TERMINAL = """
schema: 2
name: terminal
link: {port: /dev/ttyUSB0, baudrate: 115200, frame: {modbus: {}}}
channels:
  a_vacuum: {modbus: {address: 18}, unit: kPa, scale: -0.1}
  b_vacuum: {modbus: {address: 19}, unit: kPa, scale: -0.1}
  a_on: {modbus: {address: 5, bitmask: 0x0004}, on: [1]}
  b_on: {modbus: {address: 5, bitmask: 0x0300}, on: [3]}
sequence: [a, b]
actuators:
  a:
    {kind: vacuum, channel: a_vacuum,
     modbus: {address: 5, bitmask: 0x0004, command_on: [1], command_off: [0], verify: a_on}}
  b:
    {kind: vacuum, channel: b_vacuum,
     modbus: {address: 5, bitmask: 0x0300, command_on: [3], command_off: [0], verify: b_on}}
supply: {channel: none}
"""
A, B = "modbus:1/0x0005.2", "modbus:1/0x0005.8"


@pytest.fixture
def device() -> Registers:
    return Registers()


@pytest.fixture
def bus(device: Registers) -> Bus:
    return Bus(described(TERMINAL), {1: device})


def test_each_command_keeps_the_bits_of_the_others(bus: Bus, device: Registers) -> None:
    bus.to(1 * S)
    assert bus.outputs.known(bus.at) == {A: False, B: False}
    for levels, word in (({A: True}, 0x0004), ({B: True}, 0x0304), ({A: False}, 0x0300), ({B: False}, 0)):
        bus.outputs.command(levels, bus.at)
        bus.to(bus.at + 1 * S)
        assert device.written[-1] == (5, (word,))
    assert len(device.written) == 4
    assert bus.outputs.known(bus.at) == {A: False, B: False}


def test_what_changes_together_is_one_write(bus: Bus, device: Registers) -> None:
    bus.to(1 * S)
    bus.outputs.command({A: True, B: True}, bus.at)
    bus.to(bus.at + 1 * S)
    assert device.written == [(5, (0x0304,))]
    assert bus.outputs.known(bus.at) == {A: True, B: True}


def test_a_held_part_of_a_neighbour_that_was_adopted_stays_held(device: Registers) -> None:
    device.words[5] = 0x0304  # a line arbiter before this one did that
    bus = Bus(described(TERMINAL), {1: device})
    bus.to(1 * S)
    bus.outputs.command({A: False}, bus.at)
    bus.to(bus.at + 1 * S)
    assert device.written == [(5, (0x0300,))]
    assert bus.outputs.known(bus.at) == {A: False, B: True}


def test_nothing_is_written_while_a_neighbour_is_not_known(device: Registers) -> None:
    device.words[5] = 0x0304
    bus = Bus(described(TERMINAL), {1: device})
    bus.wire = lambda request, answer: answer if writes(request) else b""  # it cannot be read
    bus.outputs.command({A: False}, bus.at)
    bus.to(2 * S)
    assert device.written == []
    assert "is to be deactivated" in bus.outputs.troubles(bus.at)[A]
    bus.wire = lambda request, answer: answer
    bus.to(bus.at + 2 * S)
    assert device.written == [(5, (0x0300,))]
    assert bus.outputs.known(bus.at) == {A: False, B: True}


def test_what_another_program_has_switched_is_kept_as_it_is(bus: Bus, device: Registers) -> None:
    bus.to(1 * S)
    bus.outputs.command({A: True, B: False}, bus.at)
    bus.to(bus.at + 1 * S)
    device.words[5] |= 0x0300
    bus.to(bus.at + 1 * S)
    assert "its device reports otherwise" in bus.outputs.troubles(bus.at)[B]
    bus.outputs.command({A: False}, bus.at)
    bus.to(bus.at + 1 * S)
    assert device.written[-1] == (5, (0x0300,))
    bus.outputs.command({B: False}, bus.at)
    bus.to(bus.at + 1 * S)
    assert device.words[5] == 0


def test_two_releases_that_a_lost_unit_owes_are_one_write_when_it_is_back(
    bus: Bus, device: Registers
) -> None:
    bus.to(1 * S)
    bus.outputs.command({A: True, B: True}, bus.at)
    bus.to(bus.at + 1 * S)
    device.written.clear()
    bus.wire, answers = lambda request, answer: b"", bus.server.answer
    bus.server.answer = lambda data, at: b""  # type: ignore[method-assign]
    bus.outputs.command({B: False}, bus.at)
    bus.to(bus.at + 300 * MS)
    bus.outputs.command({A: False}, bus.at)
    bus.to(bus.at + 1 * S)
    bus.wire, bus.server.answer = lambda request, answer: answer, answers  # type: ignore[method-assign]
    bus.to(bus.at + 1 * S)
    assert device.written == [(5, (0,))]
    assert bus.outputs.known(bus.at) == {A: False, B: False}


def test_a_release_that_was_late_long_ago_delays_no_activation(bus: Bus, device: Registers) -> None:
    def late_release() -> None:
        bus.outputs.command({A: True}, bus.at)
        bus.to(bus.at + 1 * S)
        answers = bus.server.answer
        bus.server.answer = lambda data, at: b"" if writes(data) else answers(data, at)  # type: ignore[method-assign]
        bus.outputs.command({A: False}, bus.at)
        bus.to(bus.at + 300 * MS)
        bus.server.answer = answers  # type: ignore[method-assign]
        bus.to(bus.at + 1 * S)

    def delay_us(wait_us: int) -> int:
        bus.to(bus.at + wait_us)
        begun = bus.at
        bus.outputs.command({A: True}, begun)
        while not device.words[5] & 0x0004:
            bus.to(bus.at + 1 * MS)
        return bus.at - begun

    bus.to(1 * S)
    late_release()
    assert delay_us(0) > 200 * MS
    late_release()
    assert delay_us(15 * S) < 100 * MS


def test_an_activation_that_is_not_due_is_not_written_with_a_neighbour(bus: Bus, device: Registers) -> None:
    bus.to(1 * S)
    bus.outputs.command({A: True, B: True}, bus.at)
    bus.to(bus.at + 1 * S)
    device.written.clear()
    answers = bus.server.answer
    bus.server.answer = lambda data, at: b"" if writes(data) else answers(data, at)  # type: ignore[method-assign]
    bus.outputs.command({A: False}, bus.at)
    bus.to(bus.at + 400 * MS)
    bus.server.answer = answers  # type: ignore[method-assign]
    while device.words[5] & 0x0004:
        bus.to(bus.at + 1 * MS)
    bus.to(bus.at + 5 * MS)
    bus.outputs.command({B: False}, bus.at)
    bus.outputs.command({A: True}, bus.at)  # delayed as much as its release was late
    bus.to(bus.at + 200 * MS)
    assert [word for _, (word,) in device.written] == [0x0300, 0]
    bus.to(bus.at + 2 * S)
    assert [word for _, (word,) in device.written] == [0x0300, 0, 0x0004]


@pytest.mark.parametrize("mask", ["0x0004", "0x000C", "0xFFFF"])
def test_a_bit_belongs_to_one_output(mask: str) -> None:
    text = TERMINAL.replace("bitmask: 0x0300, command_on: [3]", f"bitmask: {mask}, command_on: [1]")
    (fault,) = examine_text(text, "terminal.yaml").lines()
    assert "these registers already belong to 'a'" in fault


def test_the_testbench_switches_only_the_output_whose_bits_changed() -> None:
    tool = described(TERMINAL)
    switched: list[tuple[str, bool]] = []
    devices = CommandedRegisters(tool.register_outputs, lambda name, level: switched.append((name, level)))
    devices.start({}, 0)
    for word, expected in ((0x0004, (A, True)), (0x0304, (B, True)), (0x0300, (A, False))):
        assert devices.answer(sealed(bytes([1, 6, 0, 5]) + word.to_bytes(2, "big"))) is not None
        assert switched[-1] == expected
    assert len(switched) == 3
    assert devices.values == {"a_on": False, "b_on": True}
