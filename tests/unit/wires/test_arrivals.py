"""How often readings come, in exact time: an alarm names lost samples after two seconds, and a slower period."""

from __future__ import annotations

import pytest

from end_effector_hal.codecs.described._text import TextDecoder
from end_effector_hal.description import examine_text
from end_effector_hal.signals import Frame
from end_effector_hal.wires.link._guard import ArrivalWatch

PERIOD = 20_000


def watch(*, declared: bool = False, asked: bool = False) -> ArrivalWatch:
    return ArrivalWatch(PERIOD, declared=declared, asked=asked)


def feed(of: ArrivalWatch, seconds: float, period: int = PERIOD, *, start: int = 0, b_every: int = 1) -> int:
    """Frames until then; ``b`` has a value in each of so many. Returns when the last one came."""
    at = start
    for number in range(round(seconds * 1e6) // period):
        at += period
        of.take(Frame(at, None, None, {"a": 1, "b": None if number % b_every else 1}))
    return at


@pytest.mark.parametrize("asked", [False, True])
def test_every_second_sample_of_one_sensor_is_told_within_three_seconds_and_ends(asked: bool) -> None:
    of = watch(asked=asked)
    at = feed(of, 1.9, b_every=2)
    assert of.text == ""
    at = feed(of, 1.1, start=at, b_every=2)
    assert of.text == "More than a third of the samples of b are lost: is a wire loose?"
    feed(of, 2.1, start=at)
    assert of.text == ""


def test_every_second_frame_is_told_and_a_declared_frame_names_its_period() -> None:
    of, other = watch(), watch(declared=True)
    feed(of, 3, 2 * PERIOD)
    feed(other, 3, 105_000)
    assert of.text.endswith("every 40 ms, not every 20 ms. Either samples are lost, or the device is slower.")
    assert other.text.endswith("or the device is slower: set period_ms: 105.")


def test_a_single_outage_a_slow_cycle_and_a_quarter_that_is_lost_are_not_told() -> None:
    of = watch()
    at = feed(of, 1.5)
    at = feed(of, 3, start=at + 3_000_000)
    assert of.text == ""
    feed(of, 5, PERIOD * 4 // 3, start=at)
    assert of.text == ""
    slow = watch(asked=True)
    feed(slow, 5, 4 * PERIOD)
    assert slow.text == ""


TOOL = """\
name: cup
link: {port: /dev/a, frame: {text: {}}}
channels: {cup: {text: {field: 1}, unit: kPa}}
sequence: [cup]
actuators: {cup: {kind: vacuum, line: A, channel: cup}}
supply: {channel: none}
"""


def test_a_slow_line_is_read_from_the_fourth_on_and_a_gap_is_still_one() -> None:
    from end_effector_hal.codecs import codec_of

    description = examine_text(TOOL, "tool.yaml").description
    assert description
    decoder = codec_of(description).decoder()
    assert isinstance(decoder, TextDecoder)
    at, read = 0, []
    for _ in range(5):
        at += 105_000
        read.append(len(decoder.feed(b"-62.52\r\n", at)))
    assert read == [0, 0, 0, 1, 1]
    assert not decoder.feed(b"2.52\r\n", at + 3_000_000), "it may be the tail of -62.52"
    assert decoder.feed(b"-62.52\r\n", at + 3_105_000)
