"""Declared binary records: what every codec must do, and what their keys mean."""

from __future__ import annotations

import binascii
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from end_effector_hal.codecs.conformance import EXAMPLES, CodecConformance
from end_effector_hal.signals import Frame, Value

from .declared import declared

CHANNELS = (
    "cup: {record: {byte: 0, value_type: int16, byte_order: little}, unit: hPa, invalid: [-32768]}",
    "supply: {record: {byte: 2, value_type: uint32}, unit: Pa}",
    "low: {record: {byte: 6, value_type: float32}, unit: kPa}",
    "open: {record: {byte: 10, bitmask: 0x03}, on: [1]}",
    "closed: {record: {byte: 10, bitmask: 0x03}, on: [2]}",
    "part: {record: {byte: 10, bitmask: 0x80}, invert: true}",
    "fine: {record: {byte: 11, value_type: int16, bitmask: 0x0FF0}, unit: kPa, range: [-100, 20]}",
)
VALUES: dict[str, Value] = {
    "cup": -78_300,
    "supply": 600_000,
    "low": -78_250,
    "open": False,
    "closed": True,
    "part": False,
    "fine": -78_000,
}
RECORD = struct.pack("<h", -783) + struct.pack(">If", 600_000, -78.25) + b"\x82\x0b\x20"


class Records(CodecConformance):
    pressures_pa = (-90_000, 20_000)

    def sent(self, data: st.DataObject, seq: int = 7) -> bytes:
        """One number says open and closed, so that they are never on together."""
        side = data.draw(st.sampled_from(["", "open", "closed"]), label="side")
        values: dict[str, Value] = {
            name: data.draw(st.integers(*self.pressures_pa), label=name) for name in ("cup", "low", "fine")
        }
        values |= {"supply": data.draw(st.integers(0, 700_000)), "part": data.draw(st.booleans())}
        values |= {"open": side == "open", "closed": side == "closed"}
        return self.codec.encode(Frame(0, seq, 0, values))


class TestStart(Records):
    codec = declared(
        "{record: {start: AA55, length: 13, checksum: crc16-ccitt, checksum_order: big}}", *CHANNELS
    )
    vectors = (
        (
            b"\xaa\x55" + RECORD + struct.pack(">H", binascii.crc_hqx(RECORD, 0xFFFF)),
            Frame(0, None, None, VALUES),
        ),
    )


class TestCobs(Records):
    codec = declared("{record: {framing: cobs, length: 13, checksum: crc32}}", *CHANNELS)
    # two zeros in it, each stands in a count of COBS; the last four bytes are the CRC-32 of zlib
    vectors = (
        (
            b"\0\x03\xf1\xfc" + b"\x07\x09\x27\xc0\xc2\x9c\x80" + b"\x08\x82\x0b\x20\x73\x38\x33\x53" + b"\0",
            Frame(0, None, None, VALUES),
        ),
    )


class TestSlip(Records):
    codec = declared("{record: {framing: slip, length: 13, checksum: crc16-modbus}}", *CHANNELS)
    vectors = (
        (
            b"\xc0" + RECORD.replace(b"\xc0", b"\xdb\xdc") + b"\x28\x4a\xc0",
            Frame(0, None, None, VALUES),
        ),
    )


class TestOneByte(CodecConformance):
    """Without a checksum damage is believed; what is lost costs its own record only."""

    codec = declared("{record: {framing: cobs, length: 1}}", "cup: {record: {byte: 0}, unit: kPa, scale: -1}")
    has_checksum = False
    pressures_pa = (-90_000, 0)
    vectors = (
        (b"\0\x02\x4e\0", Frame(0, None, None, {"cup": -78_000})),
        (b"\0\x01\x01\0", Frame(0, None, None, {"cup": 0})),
    )


class TestStartWithoutChecksum(CodecConformance):
    """Three in a row are believed."""

    codec = declared(
        "{record: {start: AA55, length: 2}}", "cup: {record: {byte: 0, value_type: int16}, unit: hPa}"
    )
    has_checksum = False
    unbelieved = 2
    pressures_pa = (-90_000, 700_000)
    vectors = ((b"\xaa\x55\xfc\xf1", Frame(0, None, None, {"cup": -78_300})),)


def test_a_start_that_stands_in_the_data_is_left_as_soon_as_it_is_no_start() -> None:
    codec = TestStartWithoutChecksum.codec
    true, false = b"\xaa\x55\xfc\xf1", b"\xaa\x55\xaa\x55"
    decoder = codec.decoder()
    assert decoder.feed(false[2:] + true + true, 0) == []
    assert [frame.values["cup"] for frame in decoder.feed(true + true, 0)] == [-78_300, -78_300]
    assert [frame.values["cup"] for frame in decoder.feed(true[1:] + 3 * true, 0)] == [-78_300]
    assert decoder.feed(true[:3], 1) == []
    assert decoder.feed(true[3:] + true, 100_001) == []  # bytes were lost: five periods of silence


@EXAMPLES
@given(
    cup=st.integers(-(2**15), 2**15 - 1),
    supply=st.integers(0, 2**32 - 1),
    low=st.floats(width=32),
    bits=st.integers(0, 255),
    fine=st.integers(-128, 127),
)
def test_any_record_by_an_encoder_of_its_own(cup: int, supply: int, low: float, bits: int, fine: int) -> None:
    record = struct.pack("<h", cup) + struct.pack(">If", supply, low) + bytes([bits])
    record += struct.pack(">H", (fine & 0xFF) << 4 | 0xF00F)
    (frame,) = TestStart.codec.decoder().feed(
        b"\xaa\x55" + record + struct.pack(">H", binascii.crc_hqx(record, 0xFFFF)), 3
    )
    highest = 2**31 - 1
    assert frame.values == {
        "cup": None if cup == -(2**15) else 100 * cup,
        "supply": supply if supply <= highest else None,
        "low": round(low * 1000) if low == 0 or 1e-9 <= abs(low) <= highest / 1000 else None,  # NaN: None
        "open": bits & 3 == 1,
        "closed": bits & 3 == 2,
        "part": bits < 0x80,
        "fine": 1000 * fine if -100 <= fine <= 20 else None,
    }


def test_a_record_after_a_false_start_is_found() -> None:
    """The start bytes stand in the data: what is cut off there is looked through for another."""
    good = TestStart.codec.encode(Frame(0, None, None, VALUES))
    for noise in (b"\xaa", b"\xaa\x55", b"\xaa\x55" * 5, good[:-1], b"\xaa" * 40):
        decoder = TestStart.codec.decoder()
        assert [frame.values for frame in decoder.feed(noise + good + b"\xaa", 0)] == [VALUES]
        assert [frame.values for frame in decoder.feed(good[1:], 0)] == [VALUES]


@pytest.mark.parametrize("part", [b"\xdb", b"\xdb\x00", b"\xdb\xdb\xdc", b"\x01" * 400])
def test_what_is_no_slip_is_no_record(part: bytes) -> None:
    decoder = TestSlip.codec.decoder()
    assert decoder.feed(b"\xc0" + part + b"\xc0", 0) == []
    assert decoder.errors["format"] == 1


def test_what_has_no_value_is_said_as_the_type_can() -> None:
    """Declared as invalid, out of range, or not a number; else the record is not sent."""
    codec = TestStart.codec
    for name in ("cup", "low", "fine"):
        (frame,) = codec.decoder().feed(codec.encode(Frame(0, None, None, VALUES | {name: None})), 0)
        assert frame.values == VALUES | {name: None}
    for name in ("supply", "part"):
        assert codec.encode(Frame(0, None, None, VALUES | {name: None})) == b""
    (frame,) = codec.decoder().feed(codec.encode(Frame(0, None, None, {})), 0)
    assert (frame.values["supply"], frame.values["cup"]) == (0, None)


def test_a_sensor_shows_the_end_of_its_range_and_never_what_is_declared_invalid() -> None:
    codec = declared(
        "{record: {framing: cobs, length: 2}}",
        "cup: {record: {byte: 0, value_type: uint8}, unit: kPa, offset: -100, invalid: [0, 255]}",
        "top: {record: {byte: 1, value_type: uint8}, unit: kPa, offset: -100, range: [-98.5, 10.2]}",
    )
    for pascal, cup, top in ((-100_000, 1, 2), (155_000, 254, 110), (-900_000, 1, 2), (900_000, 254, 110)):
        sent = codec.encode(Frame(0, None, None, {"cup": pascal, "top": pascal}))
        assert sent == bytes([0, 3, cup, top, 0])


def test_how_long_a_record_takes() -> None:
    cup = "cup: {record: {byte: 0}, unit: kPa}"
    slow = declared("{record: {framing: slip, length: 200}}", cup, link="baudrate: 9600")
    assert slow.least_period_us == 202 * 10_000_000 // 9600
    assert slow.period_us == slow.least_period_us
    assert declared("{record: {start: AA, length: 5}}", cup).period_us == 20_000
