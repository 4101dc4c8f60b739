"""Declared lines of text: what every codec must do, and what their keys mean."""

from __future__ import annotations

from collections import Counter

import pytest
from hypothesis import given
from hypothesis import strategies as st

from end_effector_hal.codecs.conformance import EXAMPLES, CodecConformance
from end_effector_hal.codecs.described._codec import DescribedCodec
from end_effector_hal.signals import Frame, Value

from .declared import declared


class TestFields(CodecConformance):
    codec = declared(
        '{text: {start: "$", checksum: xor8}}',
        "cup: {text: {field: 2, decimals: 1}, unit: kPa, scale: -1, range: [-105, 1000]}",
        "part: {text: {field: 1}, invert: true}",
    )
    vectors = ((b"$0,78.2*0F\r\n", Frame(0, None, None, {"cup": -78_200, "part": True})),)


class TestKeys(CodecConformance):
    codec = declared(
        "{text: {start: 'HX ', separator: ' ', checksum: crc16-modbus, checksum_mark: '#'}}",
        "cup: {text: {key: P1}, unit: mbar}",
        "far: {text: {key: P2}, unit: Pa}",
        "open: {text: {key: S}, on: [1]}",
        "closed: {text: {key: S}, on: [2]}",
    )
    pressures_pa = (-90_000, 700_000)
    vectors = (
        (
            b"HX P1=-782.5 P2=12 S=2#E4BC\r\n",
            Frame(0, None, None, {"cup": -78_250, "far": 12, "open": False, "closed": True}),
        ),
    )

    def sent(self, data: st.DataObject, seq: int = 7) -> bytes:
        """One number says both bits, so that they are never on together."""
        side = data.draw(st.sampled_from(["", "open", "closed"]), label="side")
        values: dict[str, Value] = {
            name: data.draw(st.integers(*self.pressures_pa), label=name) for name in ("cup", "far")
        }
        return self.codec.encode(
            Frame(0, seq, 0, values | {"open": side == "open", "closed": side == "closed"})
        )


class TestWithoutChecksum(CodecConformance):
    codec = declared('{text: {start: ">", separator: ";"}}', "cup: {text: {field: 1}, unit: kPa}")
    has_checksum = False
    vectors = ((b">-78.25\r\n", Frame(0, None, None, {"cup": -78_250})),)


class TestWithoutMarks(CodecConformance):
    """Nothing tells the tail of a line from a line: the first is not believed, nor one after an error."""

    codec = declared("{text: {}}", "cup: {text: {field: 1}, unit: kPa}")
    has_checksum = False
    unbelieved = 1
    vectors = ((b"-78.25\r\n", Frame(0, None, None, {"cup": -78_250})),)


def read(codec: DescribedCodec, *chunks: bytes) -> list[dict[str, Value]]:
    decoder = codec.decoder()
    return [dict(frame.values) for chunk in chunks for frame in decoder.feed(chunk, 5)]


PLAIN = declared(
    "{text: {}}",
    "cup: {text: {field: 2}, unit: kPa, scale: -0.1, range: [-105, 20], invalid: [9999]}",
    "part: {text: {key: part}, on: [1, 3]}",
)


@pytest.mark.parametrize(
    ("line", "values"),
    [
        (b"7,782.5,part=1\n", {"cup": -78_250, "part": True}),
        (b"7, 782.5 , part = 3 \r\n", {"cup": -78_250, "part": True}),
        (b"7,7.825e2,part=2,more,and=more\r\n", {"cup": -78_250, "part": False}),
        (b"7,+.5,part=1.0\r\n", {"cup": -50, "part": True}),
        (b"7,9999,part=1\r\n", {"cup": None, "part": True}),
        (b"7,1051,part=1\r\n", {"cup": None, "part": True}),
        (b"7,,part=1\r\n", {"cup": None, "part": True}),
        (b"7,nan,part=1\r\n", {"cup": None, "part": True}),
        (b"7,1_0,part=1\r\n", {"cup": None, "part": True}),
        (b"7,782.5\r\n", {"cup": -78_250, "part": None}),
        (b"7,782.5,part=\r\n", {"cup": -78_250, "part": None}),
    ],
)
def test_what_a_line_says(line: bytes, values: dict[str, Value]) -> None:
    assert read(PLAIN, b"\n", line) == [values]


def test_the_tail_of_a_line_is_no_line() -> None:
    whole, tail = b"7,782.5,part=1\n", b"2,5.5\n"
    cup = {"cup": -78_250, "part": True}
    assert read(PLAIN, tail, whole) == [cup]
    assert read(PLAIN, whole, b"7\n", tail, whole) == [cup]  # a byte has become the end of a line
    decoder = PLAIN.decoder()
    for at, data, frames in (
        (0, b"\n7,782.5", 0),
        (99_999, b",part=1\n", 1),
        (120_000, b"7,1", 0),
        (220_000, b"2.5,part=1\n", 0),  # what came before it was lost: five periods of silence
        (240_000, whole, 1),
    ):
        assert len(decoder.feed(data, at)) == frames


@pytest.mark.parametrize(
    "line", [b"\r\n", b"7\r\n", b"booting\r\n", b"rst:0x1,ready\r\n", b"7,,\r\n", b"1,2,part=1,part=0\r\n"]
)
def test_what_is_no_line_of_this_tool(line: bytes) -> None:
    decoder = PLAIN.decoder()
    assert decoder.feed(b"\n" + line, 0) == []
    assert decoder.errors["format"] == 1


def test_a_wrong_checksum_is_counted_as_one() -> None:
    codec = declared("{text: {checksum: crc8}}", "cup: {text: {field: 1}, unit: kPa}")
    line = codec.encode(Frame(0, None, None, {"cup": -78_250}))
    decoder = codec.decoder()
    assert decoder.feed(line.replace(b"78", b"87"), 0) == []
    assert decoder.errors == Counter(crc=1)
    assert decoder.feed(line.lower(), 0)


def test_what_is_counted() -> None:
    decoder = PLAIN.decoder()
    decoder.feed(b"\n", 0)
    for line in (b"7,9999,part=1\n", b"7,1051,part=1\n", b"7,hello,part=1\n"):
        assert len(decoder.feed(line, 0)) == 1
    assert decoder.errors == Counter(range=1, value=1)


def test_a_line_that_never_ends_is_given_up_and_the_next_one_read() -> None:
    for codec in (PLAIN, TestFields.codec):
        good = codec.encode(Frame(0, None, None, {"cup": 0, "part": True}))
        for filler in (b"1", b"$", b"\r"):
            decoder = codec.decoder()
            for _ in range(50):
                assert decoder.feed(100 * filler, 0) == []
            assert len(decoder.feed(b"\n" + good, 0)) == 1


@EXAMPLES
@given(st.lists(st.binary(max_size=600), max_size=8), st.integers(0, 600))
def test_long_noise_in_pieces_is_the_same_as_in_one(chunks: list[bytes], cut: int) -> None:
    for codec in (PLAIN, TestFields.codec, TestKeys.codec):
        good = codec.encode(Frame(0, None, None, {"cup": 0, "part": True, "far": 0}))
        stream = b"".join(chunks) + b"\n" + good
        assert (
            read(codec, stream[:cut], stream[cut:])
            == read(codec, stream)
            == read(codec, *chunks, b"\n", good)
        )


def test_what_has_no_value_is_said_as_the_device_can() -> None:
    """Declared as invalid; else out of range; else left out, and a line without any value is not sent."""
    none = Frame(0, None, None, {"cup": None})
    for keys, line in (
        ("invalid: [-1], range: [-105, 20]", b"-1\r\n"),
        ("range: [-105, 20]", b"-106\r\n"),
        ("scale: 2", b""),
    ):
        codec = declared("{text: {}}", f"cup: {{text: {{field: 1}}, unit: kPa, {keys}}}")
        assert codec.encode(none) == line
        assert read(codec, b"\n", line) == ([{"cup": None}] if line else [])
    blank = declared(
        "{text: {separator: ' '}}", "cup: {text: {field: 1}, unit: kPa}", "part: {text: {field: 3}}"
    )
    assert blank.encode(Frame(0, None, None, {"cup": None, "part": True})) == b"- 0 1\r\n"
    assert read(blank, b"\n- 0 1\r\n") == [{"cup": None, "part": True}]


def test_a_sensor_shows_the_end_of_its_range_for_what_lies_beyond() -> None:
    assert PLAIN.encode(Frame(0, None, None, {"cup": -200_000, "part": True})) == b"part=1,1050\r\n"


def test_what_the_line_is_by_default_and_what_the_link_says() -> None:
    cup = "cup: {text: {field: 1}, unit: kPa}"
    plain = declared("{text: {}}", cup)
    assert (plain.baudrate, plain.parity, plain.period_us) == (115_200, "N", 20_000)
    other = declared("{text: {}}", cup, link="baudrate: 9600\nparity: E\nperiod_ms: 100")
    assert (other.baudrate, other.parity, other.period_us) == (9_600, "E", 100_000)


@pytest.mark.parametrize(("decimals", "pa"), [("", 1_000), (", decimals: 0", 1_000), (", decimals: 2", 10)])
def test_how_finely_it_counts(decimals: str, pa: float) -> None:
    codec = declared("{text: {}}", f"cup: {{text: {{field: 1{decimals}}}, unit: kPa}}")
    assert codec.resolution_pa == pytest.approx(pa)


WORDS = declared(
    "{text: {equals: ':'}}",
    'part: {text: {key: Part}, on: ["ON", true]}',
    "door: {text: {key: Door}, on: [OPEN], off: [SHUT, 0], invalid: [9]}",
    "shut: {text: {key: Door}, on: [SHUT], off: [OPEN]}",
    "code: {text: {key: Code}, on: [1], off: [2]}",
    "plain: {text: {key: Plain}}",
)


@pytest.mark.parametrize(
    ("line", "values"),
    [
        (b"Part: ON, Door: OPEN, Code: 1, Plain: true\n", (True, True, False, True, True)),
        (b"Part: false, Door: SHUT, Code: 2, Plain: false\n", (False, False, True, False, False)),
        (b"Part: OFF, Door: 0, Code: 3, Plain: 2\n", (False, False, None, None, True)),
        (b"Part: on, Door: 9, Code: 1, Plain: ON\n", (None, None, None, True, None)),
        (b"Part: 0N, Door: OPEN SHUT, Code: ON, Plain: 1\n", (None, None, None, None, True)),
        (b"Part: 1, Door: SHUT, Plain: 0\n", (None, False, True, None, False)),
    ],
)
def test_a_word_is_on_or_off_and_any_other_has_no_value(line: bytes, values: tuple[Value, ...]) -> None:
    expected = dict(zip(("part", "door", "shut", "code", "plain"), values, strict=True))
    assert read(WORDS, b"\n", line) == [expected]


def test_a_device_says_words() -> None:
    values: dict[str, Value] = {"part": False, "door": False, "shut": True, "code": False, "plain": True}
    line = WORDS.encode(Frame(0, None, None, values))
    assert line == b"Part:OFF,Door:SHUT,Code:2,Plain:1\r\n"
    assert read(WORDS, b"\n", line) == [values]


@pytest.mark.parametrize(
    ("unit", "value"),
    [("Torr", 133_322), ("mmHg", 133_322), ("kg", 1_000_000), ("g", 1_000_000), ("A", 1_000_000)],
)
def test_units_of_text(unit: str, value: int) -> None:
    codec = declared(
        "{text: {}}", "cup: {text: {field: 1}, unit: kPa}", f"more: {{text: {{field: 2}}, unit: {unit}}}"
    )
    (values,) = read(codec, b"\n1,1000\n")
    assert values["more"] == value
