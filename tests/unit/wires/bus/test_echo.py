"""An adapter that hears itself: what it echoes acknowledges nothing."""

from __future__ import annotations

import pytest

from tests.unit.wires.bus.played_bus import (
    MS,
    VG10,
    Bus,
    Registers,
    described,
)


def echoing(request: bytes, answer: bytes) -> bytes:
    return request + answer


def test_an_adapter_that_hears_itself_acknowledges_nothing_in_the_place_of_a_dead_device() -> None:
    device, a = Registers(), "modbus:65/0x0000"
    bus = Bus(described(VG10), {65: device})
    bus.wire = lambda request, answer: request  # no device at all
    bus.to(300 * MS)
    bus.outputs.command({a: True}, bus.at)
    bus.to(bus.at + 900 * MS)
    assert any(request[1] == 6 for request in bus.requests)
    assert a not in bus.outputs.known(bus.at)
    assert "no device acknowledges it" in bus.outputs.troubles(bus.at)[a]


def test_over_such_an_adapter_a_device_is_read_and_commanded_like_any_other() -> None:
    device, a = Registers(), "modbus:65/0x0000"
    bus = Bus(described(VG10), {65: device})
    bus.wire = echoing
    bus.to(300 * MS)
    assert bus.frames
    bus.outputs.command({a: True}, bus.at)
    bus.to(bus.at + 100 * MS)
    assert device.written == [(0, (0x0150,))]
    assert bus.outputs.known(bus.at)[a] is True


def test_an_adapter_that_is_changed_for_one_without_an_echo_is_noticed_by_the_next_read() -> None:
    device, a = Registers(), "modbus:65/0x0000"
    bus = Bus(described(VG10), {65: device})
    bus.wire = echoing
    bus.to(300 * MS)
    bus.wire = lambda request, answer: answer
    bus.outputs.command({a: True}, bus.at)
    bus.to(bus.at + 500 * MS)
    assert bus.outputs.known(bus.at)[a] is True
    bus.wire = echoing
    bus.to(bus.at + 200 * MS)
    bus.wire = lambda request, answer: request
    bus.outputs.command({a: False}, bus.at)
    bus.to(bus.at + 900 * MS)
    assert a not in bus.outputs.known(bus.at)


def test_a_write_never_comes_before_a_read_has_shown_what_the_adapter_does() -> None:
    a = "modbus:65/0x0000"
    bus = Bus(described(VG10), {65: Registers()})
    bus.wire = lambda request, answer: request
    bus.outputs.command({a: False}, bus.at)
    bus.to(bus.at + 900 * MS)
    assert bus.requests[0][1] == 3
    assert a not in bus.outputs.known(bus.at)


@pytest.mark.parametrize("glitch", [b"", b"\x00", b"\xff\x41"], ids=["none", "a byte", "two"])
def test_an_echo_behind_a_glitch_acknowledges_nothing(glitch: bytes) -> None:
    """The line may be disturbed whenever its direction turns, also before the very first echo."""
    device, a = Registers(), "modbus:65/0x0000"
    bus = Bus(described(VG10), {65: device})
    bus.wire = lambda request, answer: glitch + request + answer
    bus.to(300 * MS)
    bus.wire = lambda request, answer: glitch + request
    bus.outputs.command({a: True}, bus.at)
    bus.to(bus.at + 900 * MS)
    assert any(request[1] == 6 for request in bus.requests)
    assert a not in bus.outputs.known(bus.at)


def test_one_echo_that_a_glitch_destroys_unlearns_nothing() -> None:
    device, a = Registers(), "modbus:65/0x0000"
    bus = Bus(described(VG10), {65: device})
    bus.wire = echoing
    bus.to(300 * MS)
    bus.wire = lambda request, answer: b"\x00" + request[1:] + answer
    reads = len(bus.requests)
    while len(bus.requests) == reads:
        bus.to(bus.at + 5 * MS)
    bus.wire = lambda request, answer: request
    bus.outputs.command({a: True}, bus.at)
    bus.to(bus.at + 900 * MS)
    assert a not in bus.outputs.known(bus.at)
