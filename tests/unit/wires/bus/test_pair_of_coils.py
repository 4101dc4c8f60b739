"""A valve with two coils that are no neighbours: one is acknowledged to be inactive before the other becomes active."""

from __future__ import annotations

import random
from itertools import groupby

import pytest

from end_effector_hal.codecs.modbus import RegisterWrite, write_request
from end_effector_hal.description import Description
from end_effector_lab.testbench import CommandedRegisters
from tests.unit.wires.bus.played_bus import MS, Bus, Registers, S, described, writes

PAIR = """
schema: 2
name: valves
link: {port: /dev/ttyUSB0, baudrate: 115200, frame: {modbus: {}}}
channels:
  one: {modbus: {address: 18}, unit: kPa, scale: -0.1}
sequence: [a]
actuators:
  a:
    {kind: vacuum, channel: one, timeout_s: 8, release_s: 3,
     modbus: {address: 3, register_type: coil, command_on: [1], command_off: [0], opposite: {address: 17}PULSE}}
supply: {channel: none}
"""
A = "modbus:1/0x0003"
FIRST, SECOND = 3, 17
HELD, PULSED = "", ", pulse_s: 0.1, pause_s: 0.2"


def tool(pulse: str) -> Description:
    return described(PAIR.replace("PULSE", pulse))


class Valve(Registers):
    """Notes each write, and says when both coils are active."""

    def write(self, address: int, values: tuple[int, ...], at: int) -> bool:
        done = super().write(address, values, at)
        assert not (self.words[FIRST] and self.words[SECOND]), "both coils"
        return done

    @property
    def coils(self) -> tuple[int, int]:
        return self.words[FIRST], self.words[SECOND]


def test_a_coil_becomes_active_after_the_other_one_is_inactive() -> None:
    valve = Valve()
    bus = Bus(tool(HELD), {1: valve})
    bus.to(1 * S)
    assert valve.written == [], "a start writes nothing"
    for level, rows, coils in (
        (True, [(SECOND, (0,)), (FIRST, (1,))], (1, 0)),
        (False, [(FIRST, (0,)), (SECOND, (1,))], (0, 1)),
    ):
        valve.written.clear()
        bus.outputs.command({A: level}, bus.at)
        bus.to(bus.at + 1 * S)
        assert (valve.written, valve.coils) == (rows, coils)
        assert bus.outputs.known(bus.at) == {A: level}


def test_a_pulse_ends_at_both_coils_also_at_the_start() -> None:
    valve, rests = Valve(), [(FIRST, (0,)), (SECOND, (0,))]
    bus = Bus(tool(PULSED), {1: valve})
    bus.to(1 * S)
    assert valve.written == rests
    valve.written.clear()
    bus.outputs.command({A: True}, bus.at)
    bus.to(bus.at + 1 * S)
    bus.outputs.command({A: False}, bus.at)
    bus.to(bus.at + 1 * S)
    grips, releases = [(SECOND, (0,)), (FIRST, (1,))], [(FIRST, (0,)), (SECOND, (1,))]
    assert valve.written == [*grips, *rests, *releases, *rests]
    assert bus.outputs.known(bus.at) == {A: False}
    assert not bus.outputs.pending


@pytest.mark.parametrize("pulse", [HELD, PULSED])
def test_a_coil_stays_inactive_while_the_end_of_the_other_one_is_not_acknowledged(pulse: str) -> None:
    valve = Valve()
    bus = Bus(tool(pulse), {1: valve})
    bus.outputs.command({A: True}, bus.at)
    bus.to(1 * S)
    valve.written.clear()
    bus.wire = lambda request, answer: b"" if writes(request) else answer
    bus.outputs.command({A: False}, bus.at)
    bus.to(bus.at + 5 * S)
    assert set(valve.written) == {(FIRST, (0,))}
    assert "no device acknowledges it" in bus.outputs.troubles(bus.at)[A]
    bus.wire = lambda request, answer: answer
    bus.to(bus.at + 3 * S)
    assert (SECOND, (1,)) in valve.written
    assert bus.outputs.known(bus.at) == {A: False}


@pytest.mark.parametrize("pulse", [HELD, PULSED])
def test_a_command_begins_again_after_a_write_without_an_answer(pulse: str) -> None:
    valve = Valve()
    bus = Bus(tool(pulse), {1: valve})
    bus.to(1 * S)
    valve.written.clear()
    lost = [True]
    set_first = write_request(RegisterWrite(1, FIRST, (1,), coils=True))

    def wire(request: bytes, answer: bytes) -> bytes:
        return b"" if request == set_first and lost and lost.pop() else answer

    bus.wire = wire
    bus.outputs.command({A: True}, bus.at)
    bus.to(bus.at + 2 * S)
    again = valve.written.index((FIRST, (1,))) + 1
    assert (SECOND, (0,)) in valve.written[again : valve.written.index((FIRST, (1,)), again)]
    assert bus.outputs.known(bus.at) == {A: True}


@pytest.mark.parametrize("pulse", [HELD, PULSED])
@pytest.mark.parametrize("seed", range(20))
def test_never_both_whatever_is_lost_and_commanded(pulse: str, seed: int) -> None:
    chooser, valve, ends = random.Random(seed), Valve(), []
    bus = Bus(tool(pulse), {1: valve})
    answered = bus.server.answer

    def answer(data: bytes, at: int) -> bytes:
        return b"" if writes(data) and chooser.random() < 0.2 else answered(data, at)

    bus.server.answer = answer  # type: ignore[method-assign]
    bus.wire = lambda request, answer: b"" if writes(request) and chooser.random() < 0.2 else answer
    for _ in range(40):
        bus.outputs.command({A: chooser.random() < 0.5}, bus.at)
        bus.to(bus.at + chooser.choice([5, 30, 150, 1000, 3000]) * MS)
        ends.append(bus.outputs.known(bus.at).get(A))
        if chooser.random() < 0.1:
            bus.power()
    assert {True, False} <= set(ends)
    bus.server.answer, bus.wire = answered, lambda request, answer: answer  # type: ignore[method-assign]
    bus.outputs.command({A: False}, bus.at)
    bus.to(bus.at + 3 * S)
    assert valve.coils == ((0, 1) if pulse == HELD else (0, 0))
    assert bus.outputs.known(bus.at) == {A: False}


def test_a_coil_whose_pulse_may_last_is_ended_until_that_is_acknowledged() -> None:
    valve = Valve()
    bus = Bus(tool(PULSED), {1: valve})
    bus.to(1 * S)
    bus.outputs.command({A: True}, bus.at)
    bus.to(bus.at + 60 * MS)
    assert valve.coils == (1, 0)
    bus.wire = lambda request, answer: b"" if writes(request) else answer
    bus.to(bus.at + 1 * S)
    assert valve.coils == (0, 0)
    assert set(valve.written[-2:]) == {(FIRST, (0,)), (SECOND, (0,))}


def test_bits_of_two_registers_are_written_with_function_22() -> None:
    text = PAIR.replace("PULSE", ", use_mask_write: true, bitmask: 0x0100").replace(
        "register_type: coil, ", ""
    )
    text = text.replace("{address: 17}", "{address: 17, bitmask: 0x0002}")
    bus = Bus(described(text), {1: Registers()})
    bus.outputs.command({"modbus:1/0x0003.8": True}, bus.at)
    bus.to(1 * S)
    sent = [request for request in bus.requests if request[1] == 22]
    assert sent == [
        write_request(RegisterWrite(1, 17, (0,), mask=0x0002)),
        write_request(RegisterWrite(1, 3, (0x0100,), mask=0x0100)),
    ]
    assert bus.outputs.known(bus.at) == {"modbus:1/0x0003.8": True}


@pytest.mark.parametrize("pulse", [HELD, PULSED])
def test_the_testbench_moves_the_valve_where_one_coil_alone_is_active(pulse: str) -> None:
    switched: list[bool] = []
    devices = CommandedRegisters(tool(pulse).register_outputs, lambda name, level: switched.append(level))
    devices.start({}, 0)
    for address, value, moved in ((FIRST, 1, [True]), (SECOND, 1, []), (FIRST, 0, []), (SECOND, 0, []),
                                  (SECOND, 1, [False])):  # fmt: skip
        request = write_request(RegisterWrite(1, address, (value,), coils=True))
        assert devices.answer(request) == request
        assert switched == moved
        switched.clear()


def test_the_end_of_a_pulse_that_was_lost_is_written_before_anything_else() -> None:
    """A device that cannot be heard gets no second pulse, and no coil of it stays active."""
    valve = Valve()
    bus = Bus(tool(PULSED), {1: valve})
    bus.outputs.command({A: True}, bus.at)
    bus.to(2 * S)
    answered, lost = bus.server.answer, [True]
    set_second = write_request(RegisterWrite(1, SECOND, (1,), coils=True))

    def answer(data: bytes, at: int) -> bytes:
        if not writes(data) or data == set_second:
            return answered(data, at)
        return b"" if valve.words[SECOND] and lost and lost.pop() else answered(data, at)

    heard = [True]

    def wire(request: bytes, answer: bytes) -> bytes:
        heard[0] = heard[0] and request != set_second
        return answer if heard[0] or not writes(request) else b""

    bus.server.answer, bus.wire = answer, wire  # type: ignore[method-assign]
    bus.outputs.command({A: False}, bus.at)
    bus.to(bus.at + 5 * S)
    assert not lost
    assert valve.coils == (0, 0)
    assert {row for row, _ in groupby(valve.written[-6:])} == {(FIRST, (0,)), (SECOND, (0,))}
    bus.wire = lambda request, answer: answer
    bus.to(bus.at + 3 * S)
    assert bus.outputs.known(bus.at) == {A: False}
    assert valve.coils == (0, 0)
