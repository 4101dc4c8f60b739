"""A gripper on a bus: commands between reads, and what the device, wires and time do to them."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from end_effector_hal.codecs.modbus import ModbusMaster, Read, Register, RelayedBus
from end_effector_hal.kinds.stanza import RegisterOutput
from end_effector_hal.wires.bus import BusOutputs, BusTraffic
from end_effector_lab.testbench.devices import sealed
from tests.support.robotiq import Gripper2F85
from tests.support.rtu_server import RtuServer
from tests.unit.wires.bus.played_bus import (
    FINGERS,
    MS,
    Bus,
    S,
    writes,
)


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
    assert tuple(values[f"fingers_{each}"] for each in ("part", "opened", "closed")) == (True, False, False)


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
    bus.wire = lambda request, answer: sealed(bytes([9, request[1] | 0x80, 2])) if writes(request) else answer
    bus.to(bus.at + 1 * S)
    refused = (
        "is to be deactivated, and its device refuses it with exception 2, illegal data address: the release is "
        "repeated until it is acknowledged"
    )
    assert bus.outputs.troubles(bus.at)[FINGERS] == refused
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
    told = len(gripper.written)
    bus.command(False)
    bus.to(bus.at + 1 * S)
    assert (
        len(gripper.written) == told
    )  # it has a fault that its activation clears, and a release has its bit
    assert "a Drop or a grip activates it first" in bus.outputs.troubles(bus.at)[FINGERS]
    bus.outputs.prepare([FINGERS], {})
    bus.command(False)
    bus.to(bus.at + 3 * S)
    assert gripper.written[told:] == [(0, 0, 0), (0x0100, 0, 0), (0x0900, 0, 0xFFFF)]
    assert bus.outputs.known(bus.at) == {FINGERS: False}


def test_only_a_drop_activates_a_device_that_lost_its_power_and_never_late(
    bus: Bus, gripper: Gripper2F85
) -> None:
    activated(bus, gripper)
    gripper.power_up(bus.at)
    told = len(gripper.written)
    bus.to(bus.at + 100 * MS)
    bus.command(False)
    bus.to(bus.at + 60 * S)
    assert len(gripper.written) == told
    bus.server = RtuServer({})
    bus.to(bus.at + 1 * S)
    bus.outputs.prepare([FINGERS], {})
    bus.command(False)
    bus.to(bus.at + 30 * S)
    bus.server = RtuServer({9: gripper})
    bus.to(bus.at + 30 * S)
    assert len(gripper.written) == told, "it was activated long after the Drop"


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


def test_a_cycle_names_the_outputs_that_were_inactive_when_it_began(bus: Bus) -> None:
    def named() -> tuple[str, ...]:
        bus.to(bus.at + 200 * MS)
        decoder = RelayedBus(bus.codec, [FINGERS]).decoder()  # type: ignore[arg-type]
        (frame,) = decoder.feed(bus.records[-1], bus.at)
        return frame.inactive

    assert named() == (FINGERS,), "nothing was commanded, and nothing shows that it is active"
    bus.command(True)
    bus.to(bus.at + 10 * S)
    assert named() == ()
    bus.command(False)
    bus.wire = lambda request, answer: answer if request[1] in (3, 4) else b""
    assert named() == (), "its device has not acknowledged it"
    bus.wire = lambda request, answer: answer
    bus.to(bus.at + 1 * S)
    assert named() == (FINGERS,)


def test_a_network_whose_reads_are_not_answered_is_written_to() -> None:
    outputs = BusOutputs(
        {"a": RegisterOutput(unit=2, address=5, command_on=(1,), command_off=(0,))}, 150 * MS
    )
    read = Read(1, 100, (Register("x", 1000.0),))
    traffic = BusTraffic(ModbusMaster((read,), baudrate=0, period_us=20 * MS, timeout_us=30 * MS), outputs)
    outputs.command({"a": False}, 0)
    assert any(traffic.poll(at)[0][:1] == b"\2" for at in range(0, 200 * MS, MS))


def test_a_late_acknowledgement_of_an_activation_is_not_that_of_the_release() -> None:
    """Function 16 acknowledges an address and a count, and RTU numbers no request."""
    two = RegisterOutput(unit=1, address=5, command_on=(1, 2), command_off=(0, 0))
    outputs = BusOutputs({"a": two}, 150 * MS)
    read = Read(1, 100, (Register("x", 1000.0),))
    traffic = BusTraffic(
        ModbusMaster((read,), baudrate=115200, period_us=20 * MS, timeout_us=30 * MS), outputs
    )
    answer = sealed(bytes([1, 16, 0, 5, 0, 2]))

    def written(values: bytes, since: int) -> int:
        return next(at for at in range(since, since + 300 * MS, MS) if values in traffic.poll(at)[0])

    outputs.command({"a": True}, 0)
    activated = written(b"\0\1\0\2", 0)
    outputs.command({"a": False}, activated + 40 * MS)
    released = written(b"\0\0\0\0", activated + 40 * MS)
    traffic.feed(answer, released + 5 * MS)
    assert "a" in outputs.owed
    again = written(b"\0\0\0\0", released + 6 * MS)
    while again < activated + 1100 * MS:
        again = written(b"\0\0\0\0", again + MS)
    traffic.feed(answer, again + 5 * MS)
    assert "a" not in outputs.owed
