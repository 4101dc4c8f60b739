"""A bus with outputs in virtual time: commands between reads, and what devices, wires and time do to them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from end_effector_hal.codecs import codec_of
from end_effector_hal.codecs.modbus import ModbusMaster, RelayedBus, cycle_record
from end_effector_hal.description import Description, examine_text
from end_effector_hal.signals import Frame
from end_effector_hal.wires.bus import BusOutputs, BusTraffic, fresh_for_us
from end_effector_lab.testbench.modbus import Gripper2F85, RegisterMap, RtuServer, SimulatedEPick

MS, S = 1_000, 1_000_000
EXAMPLES = Path(__file__).parents[4] / "examples" / "tools"
FINGERS = "modbus:9/0x03E8"
ANSWER_US = 2 * MS

VG10 = """
schema: 2
name: cups
link: {port: /dev/ttyUSB0, baudrate: 115200, parity: E, frame: {modbus: {}}}
channels:
  a_vacuum: {modbus: {unit: 65, address: 18}, unit: kPa, scale: -0.1}
  b_vacuum: {modbus: {unit: 65, address: 19}, unit: kPa, scale: -0.1}
  a_grips: {modbus: {unit: 65, address: 0, bitmask: 0xFF00}, on: [1]}
  b_grips: {modbus: {unit: 65, address: 1, bitmask: 0xFF00}, on: [1]}
sequence: [a, b]
actuators:
  a:
    {kind: vacuum, channel: a_vacuum,
     modbus: {unit: 65, address: 0, command_on: [0x0150], command_off: [0x0000], verify: a_grips}}
  b:
    {kind: vacuum, channel: b_vacuum,
     modbus: {unit: 65, address: 1, command_on: [0x0150], command_off: [0x0000], verify: b_grips}}
supply: {channel: none}
"""

TWO_UNITS = """
schema: 2
name: units
link: {port: /dev/ttyUSB0, baudrate: 115200, frame: {modbus: {timeout_ms: 200}}, period_ms: 100}
channels:
  one: {modbus: {unit: 3, address: 18}, unit: kPa, scale: -0.1}
  two: {modbus: {unit: 3, address: 19}, unit: kPa, scale: -0.1}
  three: {modbus: {unit: 3, address: 20}, unit: kPa, scale: -0.1}
sequence: [a, b, c]
actuators:
  a: {kind: vacuum, channel: one, modbus: {unit: 1, address: 0, command_on: [1], command_off: [0]}}
  b: {kind: vacuum, channel: two, modbus: {unit: 1, address: 10, command_on: [1], command_off: [0]}}
  c: {kind: vacuum, channel: three, modbus: {unit: 3, address: 0, command_on: [1], command_off: [0]}}
supply: {channel: none}
"""


def described(text: str) -> Description:
    found = examine_text(text, "cups.yaml")
    assert found.description, found.lines()
    return found.description


def example(name: str) -> Description:
    return described((EXAMPLES / name / "end_effector.yaml").read_text())


class Registers:
    """Plain ones, by address; what was written in one request stands in ``written``."""

    def __init__(self) -> None:
        self.words = dict.fromkeys(range(64), 0)
        self.written: list[tuple[int, tuple[int, ...]]] = []

    def read(self, function: int, address: int, count: int, at: int) -> list[int]:
        return [self.words[address + i] for i in range(count)]

    def write(self, address: int, values: tuple[int, ...], at: int) -> bool:
        self.written.append((address, values))
        self.words |= {address + i: value for i, value in enumerate(values)}
        return True


class Single(Registers):
    """A device that writes one register at a time."""

    def write(self, address: int, values: tuple[int, ...], at: int) -> bool:
        self.written.append((address, values))
        if len(values) > 1:
            return False
        self.words[address] = values[0]
        return True


class Bus:
    """The master, a wire, and the devices; ``wire`` changes an answer on its way, or loses it."""

    def __init__(self, tool: Description, units: dict[int, RegisterMap], at: int = 0) -> None:
        self.codec, self.at = codec_of(tool), at
        period_us = self.codec.period_us
        self.outputs = BusOutputs(tool.register_outputs, fresh_for_us(period_us))
        self.server = RtuServer(units)
        self.wire: Callable[[bytes, bytes], bytes] = lambda request, answer: answer
        self.requests: list[bytes] = []
        self.frames: list[Frame] = []
        self.records: list[bytes] = []
        self.power()

    def power(self) -> None:
        """The port is opened, anew."""
        master = self.codec.decoder()
        assert isinstance(master, ModbusMaster)
        self.traffic = BusTraffic(master, self.outputs)
        self.arriving: list[tuple[int, bytes]] = []

    def to(self, until: int) -> None:
        while True:
            due = min([self.traffic.due, *(when for when, _ in self.arriving)])
            if due > until:
                break
            self.at = max(self.at, due)
            if self.arriving and self.arriving[0][0] <= self.at:
                cycles = [self.traffic.feed(self.arriving.pop(0)[1], self.at)]
            else:
                cycles = []
            request, cycle = self.traffic.poll(self.at)
            for each in (*cycles, cycle):
                if each is not None:
                    self.records.append(cycle_record(each.answers, each.at))
                    self.frames += [each.frame] if each.frame else []
            if request:
                self.requests.append(request)
                answer = self.wire(request, self.server.answer(request, self.at))
                if answer:
                    self.arriving.append((self.at + ANSWER_US, answer))
        self.at = until
        self.outputs.advance(self.at)

    def command(self, level: bool) -> None:
        self.outputs.command({FINGERS: level}, self.at)


def writes(request: bytes) -> bool:
    return request[1] in (5, 6, 15, 16)


@pytest.fixture
def gripper() -> Gripper2F85:
    return Gripper2F85()


@pytest.fixture
def bus(gripper: Gripper2F85) -> Bus:
    return Bus(example("gripper_2f85"), {9: gripper})


def activated(bus: Bus, gripper: Gripper2F85) -> None:
    bus.command(True)
    bus.to(bus.at + 5 * S)
    assert gripper.holds
    bus.requests.clear()
    gripper.written.clear()


def test_a_start_reads_how_it_stands_and_writes_nothing(bus: Bus, gripper: Gripper2F85) -> None:
    assert bus.outputs.known(bus.at) == {}
    bus.to(2 * S)
    assert bus.outputs.known(bus.at) == {FINGERS: False}
    assert not gripper.written
    assert bus.requests[0] == bytes.fromhex("090307D00003040E")  # as in the maker's manual


def test_it_is_activated_when_it_is_commanded_then_released_and_only_then_it_grips(
    bus: Bus, gripper: Gripper2F85
) -> None:
    bus.to(1 * S)
    bus.command(True)
    while bus.at < 5 * S:
        bus.to(bus.at + 1 * MS)
        assert not bus.outputs.troubles(bus.at)
    rest, rise, off, on = (0, 0, 0), (0x0100, 0, 0), (0x0900, 0, 0xFFFF), (0x0900, 0x00FF, 0xFFFF)
    assert gripper.written == [rest, rise, off, on]
    assert gripper.holds
    assert bus.outputs.known(bus.at) == {FINGERS: True}
    values = bus.frames[-1].values
    assert (values["part"], values["opened"], values["closed"]) == (True, False, False)


def test_the_request_that_closes_it_is_that_of_the_manual(bus: Bus, gripper: Gripper2F85) -> None:
    activated(bus, gripper)
    bus.command(False)
    bus.to(bus.at + 2 * S)
    bus.command(True)
    bus.to(bus.at + 2 * S)
    assert [each.hex() for each in bus.requests if writes(each)] == [
        "091003e80003060900" + "0000" + "ffff" + "7219",
        "091003e80003060900" + "00ff" + "ffff" + "4229",
    ]


def test_a_command_waits_for_the_answer_that_is_under_way(bus: Bus, gripper: Gripper2F85) -> None:
    activated(bus, gripper)
    while not bus.arriving:
        bus.to(bus.at + 500)
    count = len(bus.requests)
    bus.command(False)
    assert bus.traffic.poll(bus.at) == (b"", None)  # whoever commands wakes the master
    bus.to(bus.at + 100)
    assert len(bus.requests) == count
    bus.to(bus.at + 10 * MS)
    assert writes(bus.requests[count])


def test_what_is_not_acknowledged_is_written_again_and_nobody_knows_how_it_stands(
    bus: Bus, gripper: Gripper2F85
) -> None:
    activated(bus, gripper)
    bus.wire = lambda request, answer: b"" if writes(request) else answer
    bus.command(False)
    bus.to(bus.at + 300 * MS)
    assert bus.outputs.known(bus.at) == {}
    assert not bus.outputs.troubles(bus.at)  # not yet: one answer may be lost
    bus.to(bus.at + 60 * S)
    assert "no device acknowledges it" in bus.outputs.troubles(bus.at)[FINGERS]
    assert len(gripper.written) > 10
    bus.wire = lambda request, answer: answer
    bus.to(bus.at + 1 * S)
    assert bus.outputs.known(bus.at) == {FINGERS: False}
    assert not bus.outputs.troubles(bus.at)


def test_an_activation_that_nobody_acknowledges_is_given_up_and_never_done_later(
    bus: Bus, gripper: Gripper2F85
) -> None:
    activated(bus, gripper)
    bus.command(False)
    bus.to(bus.at + 2 * S)
    bus.wire = lambda request, answer: b""
    bus.server = RtuServer({})
    bus.command(True)
    bus.to(bus.at + 20 * S)
    assert "was not activated" in bus.outputs.troubles(bus.at)[FINGERS]
    bus.server, bus.wire = RtuServer({9: gripper}), lambda request, answer: answer
    bus.to(bus.at + 20 * S)
    assert gripper.written[-1] == (0x0900, 0, 0xFFFF)
    assert bus.outputs.known(bus.at) == {}  # it was commanded, and its device says otherwise
    bus.command(False)
    bus.to(bus.at + 1 * S)
    assert bus.outputs.known(bus.at) == {FINGERS: False}


@pytest.mark.parametrize(
    "wire",
    [
        pytest.param(lambda request, answer: answer[:-1] + bytes([answer[-1] ^ 1]), id="damaged"),
        pytest.param(lambda request, answer: bytes([10]) + answer[1:], id="of another unit"),
        pytest.param(lambda request, answer: bytes([9, 0x90, 2, 0xCD, 0xC1]), id="refused"),
        pytest.param(lambda request, answer: answer[:5], id="cut off"),
    ],
)
def test_only_the_right_acknowledgement_counts(
    bus: Bus, gripper: Gripper2F85, wire: Callable[[bytes, bytes], bytes]
) -> None:
    activated(bus, gripper)
    bus.wire = lambda request, answer: wire(request, answer) if writes(request) else answer
    bus.command(False)
    bus.to(bus.at + 2 * S)
    assert bus.outputs.known(bus.at) == {}
    assert bus.traffic.unacknowledged > 3


def test_an_answer_that_comes_twice_counts_once(bus: Bus, gripper: Gripper2F85) -> None:
    activated(bus, gripper)
    bus.wire = lambda request, answer: answer + answer
    bus.command(False)
    bus.to(bus.at + 2 * S)
    assert bus.outputs.known(bus.at) == {FINGERS: False}
    assert gripper.written == [(0x0900, 0, 0xFFFF)]


def test_a_device_that_restarts_while_it_holds_is_told_nothing_and_counts_as_unknown(
    bus: Bus, gripper: Gripper2F85
) -> None:
    activated(bus, gripper)
    gripper.power_up(bus.at)
    bus.to(bus.at + 5 * S)
    assert not gripper.written
    assert gripper.holds
    assert bus.outputs.known(bus.at) == {}
    assert "is not activated any more" in bus.outputs.troubles(bus.at)[FINGERS]


def test_a_bus_that_is_away_while_it_holds_and_comes_back(bus: Bus, gripper: Gripper2F85) -> None:
    activated(bus, gripper)
    bus.wire = lambda request, answer: b""
    bus.server = RtuServer({})
    bus.to(bus.at + 30 * S)
    bus.server, bus.wire = RtuServer({9: gripper}), lambda request, answer: answer
    bus.power()
    bus.to(bus.at + 2 * S)
    assert bus.outputs.known(bus.at) == {FINGERS: True}
    assert gripper.holds
    assert not gripper.written


def test_the_newest_command_counts(bus: Bus, gripper: Gripper2F85) -> None:
    bus.to(1 * S)
    bus.command(True)
    bus.to(bus.at + 100 * MS)  # its activation is under way
    bus.command(False)
    bus.to(bus.at + 10 * S)
    assert gripper.written[-1] == (0x0900, 0, 0xFFFF)
    assert bus.outputs.known(bus.at) == {FINGERS: False}
    assert not gripper.holds


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


def test_a_late_answer_to_one_command_is_none_to_the_next() -> None:
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
    bus.to(bus.at + 31 * MS)  # its time-out is over
    bus.outputs.command({a: False}, bus.at)
    sent, until = len(late), bus.at + 50 * MS
    while bus.at < until and len(late) == sent:
        bus.to(bus.at + 1 * MS)
    bus.traffic.feed(late[0], bus.at)
    assert a not in bus.outputs.known(bus.at)
    bus.wire = lambda request, answer: answer
    bus.to(bus.at + 1 * S)
    assert device.words[0] == 0
    assert bus.outputs.known(bus.at)[a] is False


def test_an_activation_that_is_withdrawn_moves_nothing_any_more(bus: Bus, gripper: Gripper2F85) -> None:
    bus.to(1 * S)
    bus.command(True)
    bus.to(bus.at + 200 * MS)
    assert bus.outputs.activating(bus.at) == {FINGERS}
    told = list(gripper.written)
    bus.outputs.withdraw([FINGERS], "IL-13: the e-stop is open")
    bus.to(bus.at + 20 * S)
    assert gripper.written == told
    assert bus.outputs.troubles(bus.at) == {FINGERS: "was not activated: IL-13: the e-stop is open"}
    bus.command(False)
    bus.outputs.withdraw([FINGERS], "nothing is activated")
    bus.to(bus.at + 1 * S)
    assert gripper.written[-1] == (0x0900, 0, 0xFFFF)


def test_what_is_handed_on_gives_the_same_frames_and_noise_gives_none(bus: Bus) -> None:
    bus.to(2 * S)
    relayed = RelayedBus(bus.codec)  # type: ignore[arg-type]
    decoder = relayed.decoder()
    found = [frame for record in bus.records for frame in decoder.feed(record, bus.at)]
    assert found == bus.frames
    for noise in (
        b"\x00\xff\n",
        b"{}\n",
        bus.records[-1],  # again
        b'{"at":1,"answers":["00"]}\n',
        bus.records[0],
        b'{"at":1e9,"answers":[]}\n',
    ):
        assert decoder.feed(noise, bus.at) == []
    damaged = bus.records[-1]
    place = damaged.index(b"0903") + 8
    damaged = damaged[:place] + bytes([damaged[place] ^ 1]) + damaged[place + 1 :]
    assert relayed.decoder().feed(bus.records[-1], bus.at) == [bus.frames[-1]]
    assert relayed.decoder().feed(damaged, bus.at) == []
    frame = bus.frames[-1]
    assert relayed.decoder().feed(relayed.encode(frame), frame.at) == [frame]
    assert decoder.feed(b"x" * 100_000, bus.at) == []
    assert len(decoder._rest) < 50_000


# An adapter that hears itself


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


# Two outputs of a device that must be activated

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
