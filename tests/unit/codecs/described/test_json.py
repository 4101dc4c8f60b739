"""Declared lines of JSON: what every codec must do, and what is refused."""

from __future__ import annotations

from collections import Counter

import pytest

from end_effector_hal.codecs.conformance import CodecConformance
from end_effector_hal.signals import Frame, Value

from .declared import declared


class TestJson(CodecConformance):
    codec = declared(
        "{json: {}}",
        "cup: {json: {key: sensors.0.pressure, decimals: 2}, unit: kPa, range: [-105, 1000]}",
        "far: {json: {key: sensors.1.pressure}, unit: Pa}",
        "part: {json: {key: part}, on: [true]}",
        'door: {json: {key: door.state}, on: ["OPEN"], off: ["SHUT"], invert: true}',
    )
    has_checksum = False
    vectors = (
        (
            b'{"sensors":[{"pressure":-78.25},{"pressure":-133}],"part":true,"door":{"state":"SHUT"}}\r\n',
            Frame(0, None, None, {"cup": -78_250, "far": -133, "part": True, "door": True}),
        ),
    )

    def first(self) -> bytes:
        """A line feed ends whatever came before; no frame is discarded."""
        return b"\n"


PLAIN = declared(
    "{json: {}}",
    "cup: {json: {key: p}, unit: kPa, range: [-105, 20]}",
    "part: {json: {key: part}}",
    'state: {json: {key: state}, on: ["ON", true], invalid: [9]}',
)


def read(line: bytes) -> tuple[list[dict[str, Value]], Counter[str]]:
    decoder = PLAIN.decoder()
    frames = decoder.feed(line + b"\n", 5)
    return [dict(each.values) for each in frames], Counter({k: n for k, n in decoder.errors.items() if n})


@pytest.mark.parametrize(
    ("line", "values", "errors"),
    [
        (b'{"p":-62.4,"part":true,"state":"ON"}', (-62_400, True, True), {}),
        (b' { "x" : [1, {}], "p" : "-62.4" , "part" : 0, "state" : false } \r', (-62_400, False, False), {}),
        (b'{"p":-0.30000000000000004,"part":"true","state":"OFF"}', (-300, True, False), {}),
        (b'{"p":-106,"part":1,"state":true}', (None, True, True), {"range": 1}),
        (b'{"p":null,"part":false}', (None, False, None), {}),
        (b'{"p":true,"part":"yes","state":"on"}', None, {"format": 1}),
        (b'{"p":[-62.4],"part":1,"state":1}', (None, True, None), {"value": 1}),
        (b'{"p":-62.4,"part":1,"state":9}', (-62_400, True, None), {}),
        (b'{"p":1e400,"part":1}', (None, True, None), {"value": 1}),
    ],
)
def test_what_a_line_says(line: bytes, values: tuple[Value, ...] | None, errors: dict[str, int]) -> None:
    expected = [] if values is None else [dict(zip(("cup", "part", "state"), values, strict=True))]
    found, counted = read(line)
    assert found == expected
    assert {key: count for key, count in counted.items() if key != "range"} == {
        key: count for key, count in errors.items() if key != "range"
    }


@pytest.mark.parametrize(
    "line",
    [
        b"",
        b"booting",
        b"[1]",
        b'{"p":-62.4',
        b'2.4,"part":true}',
        b'{"p":NaN,"part":1}',
        b'{"p":-Infinity,"part":1}',
        b'{"p":-62.4,"p":-62.4}',
        b'{"p":-62.4,"x":{"y":1,"y":2}}',
        b'{"p":-62.4}{"p":-62.4}',
        b'{"p":-62.4,"part":1,"x":"\xff"}',
        b'\xef\xbb\xbf{"p":-62.4}',
        b'{"p":-62.4,"x":' + 16 * b"[" + 16 * b"]" + b"}",
        b'{"p":-62.4,"x":' + 1000 * b"[" + b"}",
        b'{"p":-62.4,"x":"' + 2048 * b"x" + b'"}',
        b'{"other":1}',
    ],
)
def test_what_is_no_line_of_this_tool(line: bytes) -> None:
    assert read(line) == ([], Counter(format=1))


def test_a_number_of_thousands_of_digits_is_no_number() -> None:
    assert read(b'{"p":' + 1900 * b"9" + b',"part":1}') == (
        [{"cup": None, "part": True, "state": None}],
        Counter(value=1),
    )


def test_what_has_no_value_is_left_out() -> None:
    values = {"cup": None, "part": True, "state": None}
    assert PLAIN.encode(Frame(0, None, None, values)) == b'{"p":-106,"part":1}\r\n'
    codec = declared("{json: {}}", "cup: {json: {key: a.3.b}, unit: kPa}", "part: {json: {key: part}}")
    assert codec.encode(Frame(0, None, None, {"cup": -1000, "part": None})) == (
        b'{"a":[null,null,null,{"b":-1}]}\r\n'
    )
    assert codec.encode(Frame(0, None, None, {"cup": None, "part": None})) == b""


def test_brackets_in_a_text_hide_no_depth() -> None:
    decoder = PLAIN.decoder()
    line = b'{"a":"' + b"]" * 990 + b'","b":' + b"[" * 990 + b"\n"
    assert decoder.feed(line, 0) == []
    assert decoder.errors["format"] == 1
