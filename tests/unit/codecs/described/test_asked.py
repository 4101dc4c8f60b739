"""Lines that answer a request: what every polled codec must do, and what happens to answers that are late."""

from __future__ import annotations

from end_effector_hal.codecs import asks
from end_effector_hal.codecs._codec import PolledDecoder
from end_effector_hal.codecs.described._asked import AskedLines
from end_effector_hal.codecs.polled_conformance import PolledCodecConformance
from end_effector_hal.signals import Frame

from .declared import declared


def asked(frame: str, *channels: str, link: str = "") -> AskedLines:
    codec = declared(frame, *channels, link=link)
    assert isinstance(codec, AskedLines)
    return codec


class TestAsked(PolledCodecConformance):
    codec = asked(
        '{text: {start: "$", checksum: crc8, ask: "READ\\r"}}',
        "cup: {text: {field: 1}, unit: kPa, invalid: [9999], range: [-105, 20]}",
        'part: {text: {field: 2}, on: ["ON"], invalid: [8]}',
    )
    vectors = (
        (
            ((b"READ\r", b"$-78.25,ON*D5\r\n"),),
            Frame(3, None, None, {"cup": -78_250, "part": True}),
        ),
    )


PLAIN = asked("{text: {ask: '?'}}", "cup: {text: {field: 1}, unit: kPa}", link="period_ms: 50")
JSON = asked('{json: {ask: "READ\\n"}}', "cup: {json: {key: p}, unit: kPa}")


def begun(codec: AskedLines) -> PolledDecoder:
    decoder = codec.decoder()
    assert asks(decoder)
    assert decoder.poll(0).data == codec.ask
    return decoder


def test_the_period_is_that_of_the_link_or_ten_times_a_second() -> None:
    assert (PLAIN.period_us, JSON.period_us) == (50_000, 100_000)
    decoder = begun(JSON)
    (frame,) = decoder.feed(b'{"p":-62.4}\r\n', 30_000)
    assert (frame.at, dict(frame.values), decoder.due) == (30_000, {"cup": -62_400}, 100_000)


def test_an_echo_and_a_prompt_are_no_answer() -> None:
    decoder = begun(JSON)
    assert decoder.feed(b"READ\r\n> ", 1000) == []
    assert len(decoder.feed(b'\r\n{"p":-62.4}\r\n> ', 2000)) == 1
    assert decoder.poll(decoder.due).data == b"READ\n"
    assert len(decoder.feed(b'{"p":-62.4}\r\n', decoder.due)) == 1


def test_the_first_answer_of_lines_without_marks_is_believed() -> None:
    assert len(begun(PLAIN).feed(b"-62.4\r\n", 1000)) == 1


def test_a_slow_answer_delays_the_next_request_and_a_late_one_is_thrown_away() -> None:
    decoder = begun(PLAIN)
    assert decoder.poll(499_999).data == b""
    assert len(decoder.feed(b"-62.4\n", 480_000)) == 1
    assert (decoder.due, decoder.poll(480_000).data) == (480_000, b"?")
    assert decoder.poll(980_000).data == b""
    assert decoder.lost == 1
    assert decoder.faults == ("no answer to '?'. Check ask, its line end, the baud rate and the wires.",)  # type: ignore[attr-defined]
    assert decoder.feed(b"-62.4\n", 1_000_000) == []
    assert decoder.poll(1_030_000).data == b"?"
    assert len(decoder.feed(b"-50\n", 1_040_000)) == 1
    assert decoder.faults == ()  # type: ignore[attr-defined]


def test_the_end_of_a_line_that_was_not_asked_for_is_no_answer() -> None:
    decoder = begun(PLAIN)
    assert len(decoder.feed(b"-62.4\n", 1000)) == 1
    assert decoder.feed(b"-6", 49_000) == []
    assert decoder.poll(50_000).data == b"?"
    assert decoder.feed(b"2.4\n", 51_000) == []
    assert [dict(each.values) for each in decoder.feed(b"-61\n", 52_000)] == [{"cup": -61_000}]


def test_a_second_answer_is_not_taken_for_the_next_one() -> None:
    decoder = begun(PLAIN)
    assert len(decoder.feed(b"-62.4\n-62.4\n-6", 1000)) == 1
    assert decoder.poll(decoder.due).data == b"?"
    (frame,) = decoder.feed(b"2\n", 60_000)
    assert dict(frame.values) == {"cup": 2_000}
    assert decoder.frames == 2
