"""Other devices on a bus: one that lets go in silence, outputs that share a device, and devices that are dead."""

from __future__ import annotations

import pytest

from end_effector_hal.wires.bus import BusOutputs, fresh_for_us
from tests.support.robotiq import SimulatedEPick
from tests.unit.wires.bus.played_bus import (
    MS,
    TWO_UNITS,
    VG10,
    Bus,
    Registers,
    S,
    described,
    example,
    writes,
)


class Single(Registers):
    """A device that writes one register at a time."""

    def write(self, address: int, values: tuple[int, ...], at: int) -> bool:
        self.written.append((address, values))
        if len(values) > 1:
            return False
        self.words[address] = values[0]
        return True


def test_an_epick_is_released_before_its_first_grip_and_reads_keep_it_alive() -> None:
    pick = SimulatedEPick()
    bus = Bus(example("epick_commanded"), {9: pick})
    bus.to(1 * S)
    bus.command(True)
    bus.to(5 * S)
    assert pick.holds
    bus.to(60 * S)
    assert pick.holds
    bus.command(False)
    bus.to(61 * S)
    assert not pick.holds


def test_an_epick_that_heard_nothing_for_a_second_has_let_go_and_is_not_commanded_again() -> None:
    pick = SimulatedEPick()
    bus = Bus(example("epick_commanded"), {9: pick})
    bus.command(True)
    bus.to(5 * S)
    told = len(pick.written)
    bus.at += 2 * S
    bus.to(bus.at + 3 * S)
    assert not pick.holds
    assert len(pick.written) == told


def test_two_channels_of_one_device_are_written_together_if_they_change_together() -> None:
    device = Registers()
    bus = Bus(described(VG10), {65: device})
    bus.to(1 * S)
    a, b = "modbus:65/0x0000", "modbus:65/0x0001"
    assert bus.outputs.known(bus.at) == {a: False, b: False}
    bus.outputs.command({a: True, b: True}, bus.at)
    bus.to(2 * S)
    assert device.written == [(0, (0x0150, 0x0150))]
    bus.outputs.command({b: False}, bus.at)
    bus.to(3 * S)
    assert device.written[1:] == [(1, (0,))]
    assert bus.outputs.known(bus.at) == {a: True, b: False}


def test_what_is_refused_together_is_written_alone() -> None:
    device = Single()
    bus = Bus(described(VG10), {65: device})
    bus.to(1 * S)
    a, b = "modbus:65/0x0000", "modbus:65/0x0001"
    bus.outputs.command({a: True, b: True}, bus.at)
    bus.to(2 * S)
    assert device.written == [(0, (0x0150, 0x0150)), (0, (0x0150,)), (1, (0x0150,))]
    assert bus.outputs.known(bus.at) == {a: True, b: True}


def test_devices_that_are_dead_keep_no_release_and_no_reading_from_the_others() -> None:
    """Unit 1 has lost its power: its two outputs are tried for ever, and each try takes the whole time-out."""
    device = Registers()
    bus = Bus(described(TWO_UNITS), {3: device})
    a, b, c = "modbus:1/0x0000", "modbus:1/0x000A", "modbus:3/0x0000"
    bus.outputs.command({a: False, b: False, c: False}, bus.at)
    bus.to(1 * S)
    assert device.written == [(0, (0,))]
    assert bus.outputs.known(bus.at) == {c: False}
    frames = len(bus.frames)
    bus.to(5 * S)
    assert len(bus.frames) > frames + 5
    assert set(bus.outputs.troubles(bus.at)) == {a, b}


@pytest.mark.parametrize("next_ms", [10, 31])  # before its time-out is over, and after
def test_a_late_answer_to_one_command_is_none_to_the_next(next_ms: int) -> None:
    """That to a write of several registers does not say which values were written."""
    device, a = Registers(), "modbus:65/0x0000"
    rows = (
        VG10.replace("[0x0150]", "[1, 1]").replace("[0x0000]", "[0, 0]").replace("address: 1,", "address: 8,")
    )
    bus = Bus(described(rows), {65: device})
    bus.to(1 * S)
    late: list[bytes] = []

    def wire(request: bytes, answer: bytes) -> bytes:
        if not writes(request):
            return answer
        late.append(answer)
        return b""

    bus.wire = wire
    bus.outputs.command({a: True}, bus.at)
    while not late:
        bus.to(bus.at + 1 * MS)
    bus.to(bus.at + next_ms * MS)
    bus.outputs.command({a: False}, bus.at)
    sent, until = len(late), bus.at + 80 * MS
    while bus.at < until and len(late) == sent:
        bus.to(bus.at + 1 * MS)
    bus.traffic.feed(late[0], bus.at)
    assert a not in bus.outputs.known(bus.at)
    bus.wire = lambda request, answer: answer
    bus.to(bus.at + 1 * S)
    assert device.words[0] == 0
    assert bus.outputs.known(bus.at)[a] is False


def test_an_acknowledgement_counts_only_for_the_command_that_was_written() -> None:
    """The device may have lost it before the same was commanded again."""
    a, tool = "modbus:65/0x0000", described(VG10)
    outputs = BusOutputs(tool.register_outputs, fresh_for_us(20 * MS))
    outputs.command({a: True}, 0)
    write = outputs.next_write(1 * MS)
    assert write is not None
    outputs.sent(write)
    outputs.command({a: False}, 5 * MS)
    outputs.command({a: True}, 10 * MS)
    outputs.acknowledged(20 * MS)
    assert outputs.known(20 * MS) == {}
    assert outputs.next_write(21 * MS) == write
    outputs.sent(write)
    outputs.acknowledged(30 * MS)
    assert outputs.known(30 * MS) == {a: True}


def test_an_acknowledgement_that_comes_twice_is_none_to_the_next_write() -> None:
    """A reset and the release behind it have the same acknowledgement, and the release is lost on its way."""
    device, a = Registers(), "modbus:65/0x0000"
    rows = VG10.replace("[0x0150]", "[1, 1]").replace("[0x0000]", "[0, 0], acknowledge: [[7, 7]]", 1)
    rows = rows.replace("[0x0000]", "[0, 0]").replace("address: 1,", "address: 8,")
    bus = Bus(described(rows), {65: device})
    bus.to(1 * S)
    bus.outputs.command({a: False}, bus.at)
    bus.to(bus.at + 1 * S)
    device.words[0] = 1  # it did not obey: it has a fault
    twice: list[bytes] = []
    answers = bus.server.answer

    def loses_releases(request: bytes, at: int) -> bytes:
        return b"" if twice and writes(request) else answers(request, at)

    def wire(request: bytes, answer: bytes) -> bytes:
        if writes(request) and answer:
            twice.append(answer)
        return answer

    bus.server.answer = loses_releases  # type: ignore[method-assign]
    bus.wire = wire
    bus.outputs.acknowledge(bus.at)
    while not twice or bus.arriving:
        bus.to(bus.at + 100)
    asked = len(bus.requests)
    while len(bus.requests) == asked:
        bus.to(bus.at + 100)
    bus.traffic.feed(twice[0], bus.at)
    bus.to(bus.at + 20 * MS)
    assert a not in bus.outputs.known(bus.at)
