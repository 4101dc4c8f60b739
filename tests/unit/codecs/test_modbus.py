"""Modbus RTU: the presets against answers in their manuals' form, and what a bus does to them."""

from __future__ import annotations

import pytest

from end_effector_hal.codecs.modbus import EPick, ModbusRtu, OnRobotVG, Read, Register, Transmitters
from end_effector_hal.codecs.polled_conformance import PolledCodecConformance
from end_effector_hal.errors import UsageError
from end_effector_hal.signals import Frame


def adu(text: str) -> bytes:
    return bytes.fromhex(text)


class TestEPick(PolledCodecConformance):
    codec = EPick()
    # The request is that of Robotiq's manuals: 09 04 07D0 0003, CRC B1CE. 0x1F: 31 kPa absolute of 100.
    vectors = (
        (
            ((adu("09 04 07D0 0003 B1CE"), adu("09 04 06 0000 0000 1F00 0F63")),),
            Frame(5, None, None, {"vacuum": -69_000}),
        ),
    )


class TestOnRobotVG(PolledCodecConformance):
    codec = OnRobotVG()
    vectors = (
        (
            ((adu("41 03 0012 0002 6ACE"), adu("41 03 04 0258 0000 3B9C")),),
            Frame(5, None, None, {"vacuum_a": -60_795, "vacuum_b": 0}),
        ),
    )


class TestTransmitters(PolledCodecConformance):
    codec = Transmitters()
    pressures_pa = (-90_000, 700_000)
    vectors = (
        (
            (
                (adu("01 03 0016 0001 65CE"), adu("01 03 02 FCF1 38C0")),
                (adu("02 03 0016 0001 65FD"), adu("02 03 02 1770 F250")),
                (adu("03 03 0016 0001 642C"), adu("03 03 02 0000 C184")),
                (adu("04 03 0016 0001 659B"), adu("04 03 02 1770 7A50")),
            ),
            Frame(5, None, None, {"bottom": -78_300, "cylinder": 600_000, "top": 0, "supply": 600_000}),
        ),
    )


def test_one_that_does_not_answer_is_invalid_and_the_others_are_known() -> None:
    codec = Transmitters()
    decoder, device, frames = codec.decoder(), codec.device(), []
    values = {"bottom": -78_300, "cylinder": 600_000, "top": 0, "supply": 600_000}
    while not frames:
        at = decoder.due
        polled = decoder.poll(at)
        frames += polled.frames
        if polled.data and polled.data[0] != 4:
            frames += decoder.feed(device.answer(polled.data, values), at + 5_000)
    assert frames[0].values == values | {"supply": None}
    assert decoder.errors["timeout"] == 1
    assert decoder.lost == 0


def test_times_of_a_cycle() -> None:
    codec = EPick()
    decoder, device = codec.decoder(), codec.device()
    assert decoder.due == 0
    request = decoder.poll(1_000_000).data
    (frame,) = decoder.feed(device.answer(request, {"vacuum": 0}), 1_004_000)
    assert frame.at == 1_004_000
    assert decoder.due == 1_020_000  # the next cycle, 50 times a second
    decoder.poll(1_020_000)
    assert decoder.due == 1_020_000 + 30_000 + 763  # the answer is overdue: the request itself takes its time
    assert decoder.poll(decoder.due).data == b""  # the line must be silent before the next request
    assert decoder.poll(decoder.due).data == request
    assert (decoder.errors["timeout"], decoder.lost) == (1, 1)


def test_an_answer_after_its_time_is_noise_for_the_next() -> None:
    codec = Transmitters()
    decoder, device = codec.decoder(), codec.device()
    first = decoder.poll(decoder.due).data
    late = device.answer(first, dict.fromkeys(codec.channels, 600_000))
    decoder.poll(decoder.due)
    decoder.poll(decoder.due)
    assert decoder.feed(late, decoder.due - 1) == []
    assert decoder.errors["noise"] == len(late)


def test_an_echo_of_the_request_does_no_harm() -> None:
    for codec in (EPick(), OnRobotVG(), Transmitters()):
        decoder, device, frames = codec.decoder(), codec.device(), []
        while not frames:
            request = decoder.poll(decoder.due).data
            frames = decoder.feed(request + device.answer(request, dict.fromkeys(codec.channels, 0)), 9)
        assert set(frames[0].values.values()) == {0}


def test_what_no_device_means_is_invalid() -> None:
    codec = OnRobotVG()
    decoder = codec.decoder()
    decoder.poll(0)
    words = [1001, 1000]
    (frame,) = decoder.feed(_answer(codec.reads[0], words), 9)
    assert frame.values == {"vacuum_a": None, "vacuum_b": -101_325}
    assert decoder.errors["range"] == 1


def _answer(read: Read, words: list[int]) -> bytes:
    from end_effector_hal.codecs.modbus import _adu

    return _adu.answer(read, words)


def test_reads_that_could_be_mixed_up_are_refused() -> None:
    reads = [Read(1, address, (Register(f"p{address}", 100.0),)) for address in (1, 7)]
    with pytest.raises(UsageError, match="answers of the same form"):
        ModbusRtu("mine", reads, baudrate=9600, period_us=100_000)


def test_a_channel_that_is_read_twice_is_refused() -> None:
    reads = [Read(unit, 1, (Register("p", 100.0),)) for unit in (1, 2)]
    with pytest.raises(UsageError, match="reads a channel twice"):
        ModbusRtu("mine", reads, baudrate=9600, period_us=100_000)


@pytest.mark.parametrize("where", ["before the answer is read", "before the next request"])
def test_a_cycle_in_which_the_process_stood_still_carries_nothing_from_before(where: str) -> None:
    codec = Transmitters()
    decoder, device = codec.decoder(), codec.device()
    values = {"bottom": -78_300, "cylinder": 600_000, "top": 0, "supply": 600_000}
    stands = 2_000_000
    first = decoder.poll(decoder.due)
    at = decoder.due - 1_000
    if where == "before the answer is read":
        at += stands
    assert decoder.feed(device.answer(first.data, values), at) == []
    if where == "before the next request":
        at += stands
    frames: list[Frame] = []
    while not frames:
        at = max(at, decoder.due)
        polled = decoder.poll(at)
        frames += polled.frames
        if polled.data:
            at += 5_000
            frames += decoder.feed(device.answer(polled.data, values | {"bottom": -1_000}), at)
    assert frames[0].values["bottom"] in (None, -1_000)
    assert decoder.errors["late"] == 1
