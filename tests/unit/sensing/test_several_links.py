"""Two links with a sequence number each: what one of them does is nothing to the channels of the other."""

from __future__ import annotations

import pytest

from end_effector_hal.codecs import carrier_of
from end_effector_hal.description import Description, examine_text
from end_effector_hal.sensing import SensorSet
from end_effector_hal.signals import Frame, clone, memory_of, recall
from end_effector_hal.vocabulary import Evidence

TOOL = """\
name: tool
links: {left: {port: /dev/a}, right: {port: /dev/b, stale_s: 0.3, down_s: 2}}
channels:
  one: {link: left, codec: {channel: bottom}}
  two: {link: right, codec: {channel: bottom}}
sequence: [a, b]
actuators:
  a: {kind: vacuum, line: A, channel: one}
  b: {kind: vacuum, line: B, channel: two}
supply: {channel: none}
"""
MS = 1000


@pytest.fixture(scope="module")
def tool() -> Description:
    found = examine_text(TOOL, "tool.yaml").description
    assert found is not None
    return found


def fed(senses: SensorSet, at: int, **seqs: int) -> int:
    """20 frames of these channels, 20 ms apart, with sequence numbers from these on; returns the end."""
    for number in range(20):
        for channel, seq in seqs.items():
            at += 10 * MS
            senses.frame(Frame(at, seq + number, 20 * (seq + number), {channel: -70_000 - number}))
    return at


def test_interleaved_numbers_are_no_reboot_and_a_reboot_is_that_of_one(tool: Description) -> None:
    senses = SensorSet(tool, carrier_of(tool))
    at = fed(senses, 0, one=1000, two=40_000)
    assert senses.now.evidence == (Evidence.CONFIRMED, Evidence.CONFIRMED)
    assert senses.notices(at, held=False) == ()
    senses.frame(Frame(at + 10 * MS, 0, 0, {"one": -70_000}))  # begins anew: its evidence, too
    assert senses.now.evidence[0] is not Evidence.CONFIRMED
    assert senses.now.readings.get("two", at + 10 * MS) == -70_019
    assert senses.now.evidence[1] is Evidence.CONFIRMED
    (said,) = [each for each in map(str, senses.notices(at + 10 * MS, held=True)) if "restarted" in each]
    assert said == "The device on the sensor link left (/dev/a) restarted; earlier readings were discarded."


def test_one_link_is_down_and_the_other_is_judged(tool: Description) -> None:
    senses = SensorSet(tool, carrier_of(tool))
    at = fed(senses, 0, one=1000, two=40_000)
    begun = at
    for again in range(1, 4):
        at = fed(senses, at, two=40_000 + 20 * again)
        senses.advance(at)
    assert senses.now.evidence == (Evidence.UNKNOWN, Evidence.CONFIRMED)
    assert senses.now.readings.down(at) == ()
    at = fed(senses, fed(senses, at, two=40_080), two=40_100)
    assert at - begun == 1000 * MS
    senses.advance(at)
    assert [each.link for each in senses.now.readings.down(at)] == ["left"]
    assert senses.notices(at, held=False) == ()  # that it is down is told elsewhere


def test_each_link_has_its_own_times(tool: Description) -> None:
    senses = SensorSet(tool, carrier_of(tool))
    at = fed(senses, 0, one=1000, two=40_000)
    readings = senses.now.readings
    assert (readings.stale_after_us("one"), readings.stale_after_us("two")) == (150 * MS, 300 * MS)
    assert readings.stale(at + 200 * MS) == ("one",)
    assert [each.link for each in readings.down(at + 1500 * MS)] == ["left"]
    assert {each.link for each in readings.down(at + 2500 * MS)} == {"left", "right"}


def test_the_age_of_a_frame_is_judged_by_its_own_link(tool: Description) -> None:
    senses = SensorSet(tool, carrier_of(tool))
    at = fed(senses, 0, one=1000, two=40_000)
    now = at + 200 * MS
    assert not senses.accepts(Frame(at + 10 * MS, 1021, 20_420, {"one": -70_000}), now)
    assert senses.accepts(Frame(at + 10 * MS, 40_021, 800_420, {"two": -70_000}), now)


def test_a_recording_that_begins_in_the_middle_goes_on_alike(tool: Description) -> None:
    first, second = (SensorSet(tool, carrier_of(tool)).now for _ in range(2))
    senses = SensorSet(tool, carrier_of(tool))
    at = fed(senses, 0, one=1000, two=40_000)
    senses.frame(Frame(at + 10 * MS, 0, 0, {"one": -70_000}))
    recall(first, memory_of(senses.now))
    assert memory_of(first) == memory_of(senses.now) == memory_of(clone(senses.now))
    assert memory_of(second) != memory_of(senses.now)
    assert first.doubts(at + 20 * MS) == senses.now.doubts(at + 20 * MS) != ()


def confirmed(tool: Description) -> tuple[SensorSet, int]:
    senses = SensorSet(tool, carrier_of(tool))
    at = 0
    for number in range(20):
        for channel in ("one", "two"):
            at += 10 * MS
            sent = Frame(at, number, 20 * number, {channel: -70_000 - number})
            assert senses.accepts(sent, at)
            senses.frame(sent)
    return senses, at


def test_a_link_that_waited_to_be_read_counts_and_no_clock_is_wrong(tool: Description) -> None:
    """As seen: the machine was late by 60 ms, another source was read first, and an alarm spoke of a wrong clock."""
    senses, at = confirmed(tool)
    now = at + 100 * MS
    newest = Frame(now, 20, 400, {"two": -70_000})
    assert senses.accepts(newest, now)
    senses.frame(newest)
    for number, late in enumerate((20, 40)):
        waited = Frame(at + late * MS, 20 + number, 400 + 20 * number, {"one": -71_000 - number})
        assert senses.accepts(waited, now)
        senses.frame(waited)
    assert senses.notices(now, held=True) == ()
    assert senses.at == now
    readings = senses.now.readings
    assert readings.get("one", at + 189 * MS) == -71_001
    assert readings.get("one", at + 190 * MS) is None, "it is as old as its own stamp says"
    assert senses.now.evidence == (Evidence.CONFIRMED, Evidence.CONFIRMED)


def test_what_waited_until_it_was_stale_is_told_as_a_standstill(tool: Description) -> None:
    senses, at = confirmed(tool)
    now = at + 400 * MS
    newest = Frame(now, 20, 400, {"two": -70_000})
    assert senses.accepts(newest, now)
    senses.frame(newest)
    assert not senses.accepts(Frame(at + 20 * MS, 20, 400, {"one": -71_000}), now)
    (said,) = map(str, senses.stamps.notices(now))
    assert said.endswith("one is too old. Did the machine stand still?")


def test_a_source_that_goes_back_itself_has_a_wrong_clock(tool: Description) -> None:
    senses, at = confirmed(tool)
    assert not senses.accepts(Frame(at - 50 * MS, 20, 400, {"two": -71_000}), at)
    (said,) = map(str, senses.stamps.notices(at))
    assert "stamped before the one that came last. Is a clock wrong" in said


BY_CONDITIONS = TOOL.replace(
    "b: {kind: vacuum, line: B, channel: two}",
    "b: {kind: vacuum, line: B, channel: two, evidence: {"
    "confirmed: {channel: two, below_kpa: -50, for_ms: 100}, gone: {channel: two, above_kpa: -10}}}",
)


def test_what_a_late_frame_shows_has_lasted_since_it_was_seen() -> None:
    tool = examine_text(BY_CONDITIONS, "tool.yaml").description
    assert tool
    senses = SensorSet(tool, carrier_of(tool))

    def take(at: int, channel: str, pa: int, seq: int) -> None:
        assert senses.accepts(Frame(at, seq, 20 * seq, {channel: pa}), 1_400 * MS)
        senses.frame(Frame(at, seq, 20 * seq, {channel: pa}))

    take(1_200 * MS, "two", 0, 1)
    take(1_390 * MS, "one", -70_000, 1)
    take(1_210 * MS, "two", -70_000, 2)  # late: nobody has looked at it for all that time
    take(1_395 * MS, "two", -70_000, 3)
    assert senses.now.evidence[1] is not Evidence.CONFIRMED
