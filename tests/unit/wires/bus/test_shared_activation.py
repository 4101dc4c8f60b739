"""Two outputs of a device that must be activated."""

from __future__ import annotations

from tests.unit.wires.bus.played_bus import (
    MS,
    VG10,
    Bus,
    Registers,
    S,
    described,
)

ACTIVATED = VG10.replace(
    "  a_grips", "  ready: {modbus: {unit: 65, address: 20}, on: [1]}\n  a_grips"
).replace("_grips}}", "_grips, activation: {write: [[9]], ready: ready, ready_within_s: 2}}}")


class Activated(Registers):
    """A device that is ready 0.3 s after its activation; it obeys nothing before."""

    ready_at = 0

    def read(self, function: int, address: int, count: int, at: int) -> list[int]:
        self.words[20] = int(bool(self.ready_at) and at >= self.ready_at)
        return super().read(function, address, count, at)

    def write(self, address: int, values: tuple[int, ...], at: int) -> bool:
        if 9 in values:
            self.ready_at = at + 300 * MS
        return super().write(address, values, at)


def test_two_that_are_commanded_together_share_one_activation_and_then_both_grip() -> None:
    device, a, b = Activated(), "modbus:65/0x0000", "modbus:65/0x0001"
    bus = Bus(described(ACTIVATED), {65: device})
    bus.to(300 * MS)
    assert bus.outputs.known(bus.at) == {a: False, b: False}
    bus.outputs.command({a: True, b: True}, bus.at)
    bus.to(bus.at + 1 * S)
    assert bus.outputs.known(bus.at) == {a: True, b: True}
    assert [values for _, values in device.written].count((9,)) == 1
    off = [index for index, (_, values) in enumerate(device.written) if 0 in values]
    on = [index for index, (_, values) in enumerate(device.written) if 0x0150 in values]
    assert max(off) < min(on)


def test_one_that_may_hold_still_keeps_the_other_from_an_activation() -> None:
    device, a = Activated(), "modbus:65/0x0000"
    device.words[1] = 0x0150
    bus = Bus(described(ACTIVATED), {65: device})
    bus.to(300 * MS)
    bus.outputs.command({a: True}, bus.at)
    bus.to(bus.at + 1 * S)
    assert not device.written
    assert "another actuator of it may hold a part" in bus.outputs.troubles(bus.at)[a]


def test_one_whose_level_nobody_knew_is_no_partner_of_an_activation() -> None:
    device, a, b = Activated(), "modbus:65/0x0000", "modbus:65/0x0001"
    bus = Bus(described(ACTIVATED), {65: device})
    bus.outputs.command({a: True, b: True}, bus.at)  # before anything was read
    bus.to(bus.at + 1 * S)
    assert not device.written
