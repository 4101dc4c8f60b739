"""A bistable valve on a bus: two coils that are pulsed, one at a time, with a pause."""

from __future__ import annotations

from itertools import groupby

import pytest

from end_effector_lab.testbench import CommandedRegisters
from end_effector_lab.testbench.devices import sealed
from tests.unit.wires.bus.played_bus import MS, Bus, Registers, S, described, writes

VALVES = """
schema: 2
name: valves
link: {port: /dev/ttyUSB0, baudrate: 115200, frame: {modbus: {}}}
channels:
  one: {modbus: {address: 18}, unit: kPa, scale: -0.1}
  two: {modbus: {address: 19}, unit: kPa, scale: -0.1}
sequence: [a, b]
actuators:
  a:
    {kind: vacuum, channel: one, release_s: 3,
     modbus: {address: 0, command_on: [1, 0], command_off: [0, 1], pulse_s: 0.1, pause_s: 0.4}}
  b: {kind: vacuum, channel: two, modbus: {address: 5, command_on: [1], command_off: [0]}}
supply: {channel: none}
"""
A, B = "modbus:1/0x0000", "modbus:1/0x0005"
ON, OFF, REST = (1, 0), (0, 1), (0, 0)


class Timed(Registers):
    """Notes what was written to the valve, and when."""

    def __init__(self) -> None:
        super().__init__()
        self.pulses: list[tuple[tuple[int, ...], int]] = []

    def write(self, address: int, values: tuple[int, ...], at: int) -> bool:
        assert self.words[0] + self.words[1] < 2, "both coils"
        if address == 0:
            self.pulses.append((values, at))
        return super().write(address, values, at)

    @property
    def rows(self) -> list[tuple[int, ...]]:
        return [values for values, _ in self.pulses]


@pytest.fixture
def valve() -> Timed:
    return Timed()


@pytest.fixture
def bus(valve: Timed) -> Bus:
    bus = Bus(described(VALVES), {1: valve})
    bus.to(1 * S)
    assert valve.rows == [REST], "the end of what an earlier arbiter may have begun"
    valve.pulses.clear()
    return bus


def test_each_command_is_a_pulse_and_the_next_one_waits_for_its_pause(bus: Bus, valve: Timed) -> None:
    bus.outputs.command({A: True}, bus.at)
    bus.to(bus.at + 50 * MS)
    assert bus.outputs.known(bus.at) == {A: True}
    bus.outputs.command({A: False}, bus.at)
    assert A not in bus.outputs.known(bus.at)
    bus.to(bus.at + 2 * S)
    assert valve.rows == [ON, REST, OFF, REST]
    (_, on), (_, rest), (_, off), (_, end) = valve.pulses
    assert 100 * MS <= rest - on <= 130 * MS
    assert 400 * MS <= off - rest <= 430 * MS
    assert 100 * MS <= end - off <= 130 * MS
    assert bus.outputs.known(bus.at) == {A: False}
    assert not bus.outputs.pending


def test_a_pulse_keeps_no_other_output_of_the_unit_waiting(bus: Bus, valve: Timed) -> None:
    bus.outputs.command({A: True}, bus.at)
    bus.to(bus.at + 20 * MS)
    bus.outputs.command({B: True}, bus.at)
    bus.to(bus.at + 40 * MS)
    assert (valve.words[5], valve.rows) == (1, [ON])


def test_an_activation_that_nobody_acknowledges_ends_with_its_pulse(bus: Bus, valve: Timed) -> None:
    """The device may have it: no coil stays active for longer than the bus is lost."""
    bus.wire = lambda request, answer: b"" if writes(request) else answer
    bus.outputs.command({A: True}, bus.at)
    bus.to(bus.at + 3 * S)
    assert "was not activated" in bus.outputs.troubles(bus.at)[A]
    assert valve.rows[0] == ON
    assert valve.rows[-1] == REST
    bus.wire = lambda request, answer: answer
    bus.to(bus.at + 1 * S)
    valve.pulses.clear()
    bus.to(bus.at + 2 * S)
    assert not valve.rows, "nothing is done late"
    assert valve.words[0] == 0


def test_a_release_is_pulsed_as_soon_as_the_bus_is_back(bus: Bus, valve: Timed) -> None:
    bus.outputs.command({A: True}, bus.at)
    bus.to(bus.at + 1 * S)
    answer = bus.server.answer
    bus.server.answer = lambda data, at: b""  # type: ignore[method-assign]
    bus.outputs.command({A: False}, bus.at)
    bus.to(bus.at + 30 * S)
    assert bus.outputs.owed == {A}
    bus.server.answer = answer  # type: ignore[method-assign]
    bus.to(bus.at + 3 * S)
    # an acknowledgement that may be that of an earlier write does not count, so that the end is written again
    assert [row for row, _ in groupby(valve.rows)] == [ON, REST, OFF, REST]
    assert bus.outputs.known(bus.at) == {A: False}
    assert not bus.outputs.pending


def test_a_device_that_cannot_be_heard_obeys_a_release_by_pulses_that_end(bus: Bus, valve: Timed) -> None:
    bus.outputs.command({A: True}, bus.at)
    bus.to(bus.at + 1 * S)
    bus.wire = lambda request, answer: b""
    bus.outputs.command({A: False}, bus.at)
    bus.to(bus.at + 10 * S)
    assert bus.outputs.owed == {A}
    assert valve.rows[:6] == [ON, REST, OFF, REST, OFF, REST]
    pairs = list(zip(valve.pulses, valve.pulses[1:], strict=False))
    assert all(after - before <= 400 * MS for (row, before), (_, after) in pairs if row != REST)
    assert all(after - before >= 400 * MS for (row, before), (_, after) in pairs if row == REST)


def test_a_coil_whose_pulse_does_not_end_is_said(bus: Bus, valve: Timed) -> None:
    bus.outputs.command({A: True}, bus.at)
    bus.to(bus.at + 50 * MS)
    bus.power()  # the port was opened again: the pulse has its length
    bus.wire = lambda request, answer: b""
    bus.server.answer = lambda data, at: b""  # type: ignore[method-assign]
    bus.to(bus.at + 3 * S)
    assert "acknowledges the end of the pulse" in bus.outputs.troubles(bus.at)[A]
    assert valve.rows == [ON]
    assert bus.outputs.pending


def test_the_testbench_leaves_the_valve_where_a_pulse_has_moved_it() -> None:
    switched: list[tuple[str, bool]] = []
    tool = described(VALVES)
    devices = CommandedRegisters(tool.register_outputs, lambda name, level: switched.append((name, level)))
    devices.start({}, 0)
    for row in (ON, REST, OFF, REST):
        words = b"".join(word.to_bytes(2, "big") for word in row)
        done = devices.answer(sealed(bytes([1, 16, 0, 0, 0, 2, 4]) + words))
        assert done is not None
        assert done[1] == 16
    assert switched == [(A, True), (A, False)]


@pytest.mark.parametrize("heard_ms", range(0, 1000, 50))
def test_no_release_before_it_prolongs_a_pulse(valve: Timed, heard_ms: int) -> None:
    """The release before is acknowledged, by another unit, while the pulse runs."""
    far = "modbus:2/0x0005"
    bus = Bus(described(VALVES.replace("{address: 5,", "{unit: 2, address: 5,")), {1: valve, 2: Registers()})
    bus.outputs.command({A: True, far: True}, bus.at)
    bus.to(bus.at + 1 * S)
    bus.wire = lambda request, answer: b""
    bus.outputs.command({far: False}, bus.at)
    bus.to(bus.at + 2 * S)
    bus.outputs.command({A: False}, bus.at)
    bus.to(bus.at + heard_ms * MS)
    bus.wire = lambda request, answer: answer
    bus.to(bus.at + 6 * S)
    assert valve.rows[-2:] == [OFF, REST]
    pairs = zip(valve.pulses, valve.pulses[1:], strict=False)
    assert all(after - before <= 400 * MS for (row, before), (_, after) in pairs if row != REST)
