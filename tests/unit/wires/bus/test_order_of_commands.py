"""The order of the commands counts after a loss, too: within a unit always, on the bus when its port opens again."""

from __future__ import annotations

import pytest

from end_effector_hal.wires.bus import BusOutputs
from end_effector_lab.testbench.devices import sealed
from tests.support.handshake_gripper import HandshakeGripper
from tests.support.rtu_server import RtuServer
from tests.unit.wires.bus.played_bus import MS, TWO_UNITS, VG10, Bus, Registers, S, described, writes
from tests.unit.wires.bus.test_handshake import JAWS
from tests.unit.wires.bus.test_handshake import TOOL as HANDSHAKE

A, B = "modbus:65/0x0000", "modbus:65/0x0001"
FAR, OTHER, LAST = "modbus:1/0x0000", "modbus:1/0x000A", "modbus:3/0x0000"
GATEWAY_TARGET, BUSY, ILLEGAL_VALUE = 11, 6, 3


class Device(Registers):
    """Registers that write to a common list, in the order of the bus."""

    def __init__(self, unit: int, order: list[tuple[int, int, int]]) -> None:
        super().__init__()
        self.unit, self.order = unit, order

    def write(self, address: int, values: tuple[int, ...], at: int) -> bool:
        self.order += [(self.unit, address + i, value) for i, value in enumerate(values)]
        return super().write(address, values, at)


@pytest.mark.parametrize("away_ms", [150, 333, 1000])
@pytest.mark.parametrize("later_ms", [40, 75, 110, 250])
def test_what_was_commanded_first_is_written_first_when_a_unit_is_back(away_ms: int, later_ms: int) -> None:
    order: list[tuple[int, int, int]] = []
    tool = described(VG10.replace("address: 1, c", "address: 9, c"))
    first, second = A, "modbus:65/0x0009"
    bus = Bus(tool, {})
    bus.to(1 * S)
    bus.outputs.command({second: False}, bus.at)
    bus.to(bus.at + later_ms * MS)
    bus.outputs.command({first: False}, bus.at)
    bus.to(bus.at + away_ms * MS)
    bus.server = RtuServer({65: Device(65, order)})
    bus.to(bus.at + 2 * S)
    assert order == [(65, 9, 0), (65, 0, 0)]


@pytest.mark.parametrize("later_ms", [40, 400, 2000, 60_000])
def test_releases_that_waited_for_a_unit_keep_their_distance(later_ms: int) -> None:
    times: list[int] = []

    class Timed(Registers):
        def write(self, address: int, values: tuple[int, ...], at: int) -> bool:
            times.append(at)
            return super().write(address, values, at)

    tool = described(VG10.replace("address: 1, c", "address: 9, c"))
    bus, earlier = Bus(tool, {}), "modbus:65/0x0009"
    bus.to(1 * S)
    bus.outputs.command({earlier: False}, bus.at)
    bus.at += later_ms * MS
    bus.outputs.command({A: False}, bus.at)
    bus.to(bus.at + 3 * S)
    bus.server = RtuServer({65: Timed()})
    bus.to(bus.at + 4 * S)
    first, second = times
    expected = min(later_ms * MS, tool.release_us[earlier])  # no longer than the release takes
    assert expected <= second - first <= expected + 100 * MS


def test_a_neighbour_that_is_commanded_later_does_not_overtake_what_stands_between() -> None:
    order: list[tuple[int, int, int]] = []
    third = "{kind: vacuum, channel: c_vacuum, modbus: {unit: 65, address: 20, command_on: [1], command_off: [0]}}"
    text = (
        VG10.replace("[a, b]", "[a, b, c]")
        .replace("supply:", f"  c: {third}\nsupply:")
        .replace(
            "sequence:", "  c_vacuum: {modbus: {unit: 65, address: 20}, unit: kPa, scale: -0.1}\nsequence:"
        )
    )
    bus = Bus(described(text), {})
    for name in (A, "modbus:65/0x0014", B):
        bus.outputs.command({name: False}, bus.at)
        bus.to(bus.at + 10 * MS)
    bus.server = RtuServer({65: Device(65, order)})
    bus.to(2 * S)
    assert order == [(65, 0, 0), (65, 20, 0), (65, 1, 0)]


def test_after_the_port_was_lost_the_units_are_written_in_the_order_of_the_commands() -> None:
    order: list[tuple[int, int, int]] = []
    bus = Bus(described(TWO_UNITS), {})
    bus.outputs.command({OTHER: False}, bus.at)
    bus.to(500 * MS)
    bus.outputs.command({LAST: False}, bus.at)  # the write before fails again, and is due later than this one
    bus.at += 2 * S
    bus.outputs.command({FAR: False}, bus.at)
    bus.server = RtuServer({unit: Device(unit, order) for unit in (1, 3)})
    bus.power()
    bus.to(bus.at + 4 * S)
    assert order == [(1, 10, 0), (3, 0, 0), (1, 0, 0)]


@pytest.mark.parametrize(("later_ms", "takes_ms"), [(2000, 20), (50, 300)])
def test_a_handshake_is_not_overtaken_when_the_port_opens(later_ms: int, takes_ms: int) -> None:
    """The jaws were released before the cup, on another unit; their handshake may take longer than that."""
    order: list[tuple[int, int, int]] = []
    cup = "  cup: {kind: vacuum, channel: kpa, modbus: {unit: 3, address: 0, command_on: [1], command_off: [7]}}\n"
    text = HANDSHAKE.replace("[jaws]", "[cup, jaws]").replace("supply:", f"{cup}supply:")
    text = text.replace("sequence:", "  kpa: {modbus: {unit: 3, address: 20}, unit: kPa}\nsequence:")
    tool, jaws = described(text), HandshakeGripper()
    jaws.takes_us = takes_ms * MS
    bus = Bus(tool, {})
    bus.outputs.command({JAWS: False}, bus.at)
    bus.at += later_ms * MS
    bus.outputs.command({LAST: False}, bus.at)
    bus.at += 2 * S
    bus.server = RtuServer({1: jaws, 3: Device(3, order)})
    bus.power()
    while not order:
        bus.to(bus.at + 10 * MS)
    assert jaws.written[-1] == (0x0100, 50), "its release"
    opened = bus.at
    bus.to(opened + 1 * S)
    assert order == [(3, 0, 7)]


@pytest.mark.parametrize(
    ("exception", "seconds", "follows"),
    [
        pytest.param(ILLEGAL_VALUE, 3, True, id="refused for good"),
        pytest.param(BUSY, 3, False, id="busy"),
        pytest.param(BUSY, 8, True, id="busy for so long that nothing may stay on for it"),
        pytest.param(GATEWAY_TARGET, 3, False, id="a gateway that does not reach it"),
    ],
)
def test_only_what_a_device_refuses_for_good_is_overtaken(
    exception: int, seconds: int, *, follows: bool
) -> None:
    order: list[tuple[int, int, int]] = []
    bus = Bus(described(VG10), {65: Device(65, order)})
    bus.to(1 * S)
    answers = bus.server.answer

    def refuses(data: bytes, at: int) -> bytes:
        if writes(data) and data[2:4] == b"\0\0":
            return sealed(bytes([65, data[1] | 0x80, exception]))
        return answers(data, at)

    bus.server.answer = refuses  # type: ignore[method-assign]
    bus.outputs.command({A: False}, bus.at)
    bus.to(bus.at + 20 * MS)
    bus.outputs.command({B: False}, bus.at)
    bus.to(bus.at + seconds * S)
    assert bool(order) is follows
    bus.server.answer = answers  # type: ignore[method-assign]
    bus.to(bus.at + 1 * S)
    assert sorted(order) == [(65, 0, 0), (65, 1, 0)]


def test_a_write_that_waits_for_its_turn_does_not_keep_the_bus_awake() -> None:
    outputs = BusOutputs(described(VG10).register_outputs, 150 * MS)
    outputs.command({A: False}, 0)
    write = outputs.next_write(0)
    assert write is not None
    outputs.sent(write)
    outputs.failed(30 * MS)
    outputs.command({B: False}, 40 * MS)
    assert outputs.next_write(129 * MS) is None
    assert outputs.due == 130 * MS


@pytest.mark.parametrize("late_ms", [0, 70, 230])
def test_a_late_release_delays_the_activation_after_it(late_ms: int) -> None:
    """A device gets both commands at least as far apart as they were given."""
    times: list[int] = []

    class Timed(Registers):
        def write(self, address: int, values: tuple[int, ...], at: int) -> bool:
            times.append(at)
            return super().write(address, values, at)

    bus = Bus(described(VG10), {})
    bus.to(1 * S)
    bus.outputs.command({A: False}, bus.at)
    given = bus.at
    bus.to(given + late_ms * MS)
    bus.server = RtuServer({65: Timed()})
    bus.to(given + 1 * S)
    bus.outputs.command({A: True}, bus.at)
    bus.to(bus.at + 2 * S)
    released, activated = times
    assert 1 * S <= activated - released <= 1.2 * S
