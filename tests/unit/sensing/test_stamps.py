"""A time stamp that is ahead of now, too old or out of order never counts, and nothing freezes; in virtual time."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from end_effector_hal.arbiter import PredicatePublisher
from end_effector_hal.codecs import get_codec
from end_effector_hal.control import Status
from end_effector_hal.description import Description, examine_text, load, profile_path
from end_effector_hal.sensing import Predicates, SensorSet
from end_effector_hal.signals import Frame, StampGate, Value, memory_of, recall
from end_effector_hal.vocabulary import Alarm
from tests.support.nightly import first_of
from tests.support.virtual_tool import VirtualTool

GRIPPING, GRIPPED, STAND_BY = 1, 3, 6
YEAR_2038 = 2_147_483_647_000_000
STALE = 150_000
DOUBT = "Is a clock wrong, or does somebody else publish them?"


@pytest.fixture(scope="module")
def description() -> Description:
    return load(profile_path())


def refused(why: str) -> Alarm:
    return Alarm("stamps.refused", "Sensor frames", {"why": why, "doubt": DOUBT})


# Stamps, by the time at which they come

NOW = 5_000_000
WRONG: list[tuple[Any, str]] = [
    (NOW + 1, "stamped ahead of now"),
    (YEAR_2038, "stamped ahead of now"),
    (-1, "stamped with what is no time"),
    (-(2**63), "stamped with what is no time"),
    (2**63, "stamped with what is no time"),
    (10**5000, "stamped with what is no time"),
    (float("nan"), "stamped with what is no time"),
    (float("inf"), "stamped with what is no time"),
    (float(NOW), "stamped with what is no time"),
    (True, "stamped with what is no time"),
    (None, "stamped with what is no time"),
    ("now", "stamped with what is no time"),
]


@pytest.mark.parametrize(
    ("stamp", "why"), WRONG, ids=lambda each: None if isinstance(each, str) else type(each).__name__
)
def test_a_wrong_stamp_is_refused_counted_and_told_for_ten_seconds(stamp: object, why: str) -> None:
    gate = StampGate("Sensor frames", old_us=STALE)
    assert gate.passes(NOW - STALE + 1, NOW)
    assert (gate.refused, gate.notices(NOW), gate.deadline(NOW)) == (0, (), None)
    assert not gate.passes(stamp, NOW)
    assert gate.refused == 1
    assert gate.notices(NOW + 9_999_999) == (refused(why),)
    assert gate.deadline(NOW) == NOW + 10_000_000
    assert gate.notices(NOW + 10_000_000) == ()
    assert gate.passes(NOW + 20_000_000, NOW + 20_000_000)


@pytest.mark.parametrize(("age_us", "said_s"), [(STALE, 1), (59_999_999, 1), (60_000_000, 10), (10**12, 10)])
def test_what_came_late_is_told_for_a_second_and_what_is_far_too_old_for_ten(
    age_us: int, said_s: int
) -> None:
    gate, now = StampGate("Sensor frames", old_us=STALE), 2 * 10**12
    assert not gate.passes(now - age_us, now)
    (text,) = map(str, gate.notices(now + said_s * 1_000_000 - 1))
    assert text.startswith("Sensor frames are refused and count for nothing: one is too old.")
    assert text.endswith("Did the machine stand still?" if said_s == 1 else DOUBT)
    assert gate.notices(now + said_s * 1_000_000) == ()


def test_a_wrong_stamp_is_told_although_one_came_late() -> None:
    gate = StampGate("Sensor frames", old_us=STALE)
    assert not gate.passes(NOW - STALE, NOW)
    assert not gate.passes(NOW + 1_000_000, NOW)
    assert not gate.passes(NOW - STALE, NOW)
    assert gate.notices(NOW + 9_999_999) == (refused("stamped ahead of now"),)


def test_what_is_older_than_the_last_that_counted_is_refused() -> None:
    gate = StampGate("Sensor frames", in_order=True)
    assert gate.passes(1000, NOW)
    assert gate.passes(1000, NOW)  # two frames of one read
    assert not gate.passes(NOW + 1, NOW)  # one that is refused is not the last
    assert not gate.passes(999, NOW)
    assert gate.passes(1001, NOW)


def test_after_a_standstill_what_is_old_and_out_of_order_came_late() -> None:
    gate = StampGate("Sensor frames", old_us=STALE, in_order=True)
    assert gate.passes(NOW, NOW)
    assert not gate.passes(NOW - 1, NOW + STALE)
    (text,) = map(str, gate.notices(NOW + STALE))
    assert "one is too old. Did the machine stand still?" in text
    assert not gate.passes(NOW - 1, NOW + 1)


def test_the_words_of_its_beginning_stand_until_it_is_over_and_the_next_ones_count() -> None:
    gate = StampGate("Sensor frames")
    for late in range(50):
        assert not gate.passes(YEAR_2038, NOW + late)
        assert gate.notices(NOW + late) == (refused("stamped ahead of now"),)
    gate.passes(-1, NOW + 20_000_000)
    assert gate.notices(NOW + 20_000_000) == (refused("stamped with what is no time"),)


def test_the_same_fault_is_the_same_alarm_each_time() -> None:
    """With numbers in it an alarm that comes and goes would be a new one each time; `refused` has the count."""
    gate = StampGate("Sensor frames", old_us=STALE)
    told = set()
    for number in range(5):
        now = NOW + number * 2_000_000
        assert gate.notices(now) == ()
        assert not gate.passes(now - STALE - number, now)
        told.update(gate.notices(now))
    assert len(told) == 1
    assert gate.refused == 5


# A whole tool: one wrong frame changes nothing but an alarm


TWO_LINKS = """\
name: tool
links:
  left: {port: /dev/a, frame: {text: {}}}
  right: {port: /dev/b, frame: {text: {}}}
channels:
  cup: {link: left, text: {field: 1}, unit: kPa}
  stop: {link: right, text: {field: 1}}
sequence: [cup]
actuators: {cup: {kind: vacuum, line: A, channel: cup}}
e_stop: {channel: stop}
supply: {channel: none}
"""


def script(tool: VirtualTool, wrong: object = None) -> list[Status]:
    """A grip and a drop; a frame that would show the opposite comes with a wrong stamp in every state."""
    tool.run(1.0)
    for command, seconds in (("grip", 0.1), ("", 3.9), ("drop", 0.1), ("", 3.9)):
        if wrong is not None:
            stamp: Any = tool.at + wrong if type(wrong) is int and wrong < 0 else wrong
            kinds = tool.codec.channels
            values: dict[str, Value] = dict.fromkeys(kinds)
            told = tool.controller.frame(Frame(stamp, None, None, values), tool.at)
            assert all("are refused" in str(status.alarm_texts) for status in told)
        if command:
            assert tool.command(command).accepted
        tool.run(seconds)
    return [replace(status, alarms=(), refused_frames=0) for status in tool.statuses]


def moves(statuses: list[Status]) -> list[tuple[object, ...]]:
    rows = [(each.ee, each.command, each.actuators, each.outputs, each.evidence) for each in statuses]
    found = [(statuses[0].at, *rows[0])]
    for before, row, status in zip(rows, rows[1:], statuses[1:], strict=False):
        if row != before:
            found.append((status.at, *row))
    return found


@pytest.mark.parametrize(
    "wrong",
    first_of([YEAR_2038, -STALE, float("nan"), "now", 2**63 - 1, 2**70, 0, -20_001, float("inf")], 4, 2),
    ids=lambda each: repr(each)[:12],
)
def test_a_wrong_frame_moves_nothing_in_any_state(description: Description, wrong: object) -> None:
    good = VirtualTool(description)
    expected = moves(script(good))
    assert [row[1] for row in expected][-1] == STAND_BY
    tool = VirtualTool(description)
    assert moves(script(tool, wrong)) == expected  # to the microsecond
    assert tool.edges == good.edges
    status = tool.status
    assert status.refused_frames == 4
    assert all("are refused" in each for each in status.alarm_texts)


def test_a_grip_ends_although_every_second_frame_comes_from_the_future(description: Description) -> None:
    """As seen: GRIPPING did not end in 65 s."""
    tool = VirtualTool(description, "never-confirms:bottom_vacuum")
    tool.run(1.0)
    assert tool.command("grip").accepted
    for _ in range(30):
        tool.controller.frame(Frame(YEAR_2038, None, None, {"bottom": -80_000}), tool.at)
        tool.run(1.0)
    status = tool.status
    assert (status.ee, status.at) == (STAND_BY, tool.at)
    assert status.refused_frames == 30
    assert "Sensor frames are refused" in status.alarm_texts[0]
    assert status.missed == 0


def test_while_held_nothing_is_let_go_and_the_alarm_ends(description: Description) -> None:
    tool = VirtualTool(description)
    tool.run(1.0)
    tool.command("grip")
    tool.run(4.0)
    edges = tool.edges.copy()
    told = tool.controller.frame(Frame(YEAR_2038, None, None, {"bottom": 0, "top": 0}), tool.at)
    assert [(status.ee, status.lift_allowed) for status in told] == [(GRIPPED, True)]
    (alarm,) = told[0].alarm_texts
    assert alarm.startswith("Sensor frames are refused and count for nothing: one is stamped ")
    assert tool.controller.frame(Frame(YEAR_2038, None, None, {"bottom": 0}), tool.at) == []  # said already
    tool.run(9.9)
    assert tool.status.alarm_texts == (alarm,)
    tool.run(0.2)
    assert tool.status.alarm_texts == ()
    assert (tool.status.ee, tool.edges) == (GRIPPED, edges)


def test_only_wrong_frames_are_a_silence(description: Description) -> None:
    tool = VirtualTool(description)
    tool.run(1.0)
    tool.link = False
    for _ in range(100):
        tool.run(0.02)
        tool.controller.frame(Frame(tool.at + 60_000_000, None, None, tool.bench.sample(tool.at)), tool.at)
    status = tool.status
    assert (status.link_up, set(status.evidence)) == (False, {0})
    assert "The sensor link /dev/verdin-uart1 is down." in status.alarm_texts
    assert not tool.command("grip").accepted


# What else takes frames: predicates for the line arbiter, the nodes


def test_a_frame_from_the_future_proves_nothing_to_the_line_arbiter(description: Description) -> None:
    codec = get_codec(description.link.codec)
    predicates = Predicates(description, codec)
    locked: dict[str, Value] = {"locked": True, "unlocked": False, "tool_present": True}
    for at in range(1_000_000, 1_200_000, 20_000):
        assert predicates.frame(Frame(YEAR_2038, None, None, locked), at) == {}
        assert predicates.frame(Frame(at, None, None, {**locked, "locked": False}), at)["locked"] is False
    assert predicates.advance(1_400_000)["locked"] is False


def test_the_publisher_sends_no_stamp_that_is_ahead_of_now(
    description: Description, monkeypatch: pytest.MonkeyPatch
) -> None:
    told: list[int] = []
    now = [1_000_000]
    publisher = PredicatePublisher(description, clock=lambda: now[0])
    monkeypatch.setattr(publisher._sender, "send", lambda said, at: told.append(at) or True)
    values: dict[str, Value] = {"locked": True, "unlocked": False, "tool_present": True}
    publisher.frame(Frame(YEAR_2038, None, None, values))
    assert told == []
    for _ in range(10):
        publisher.frame(Frame(now[0], None, None, values))
        now[0] += 20_000
    assert told == [1_000_000, 1_040_000, 1_080_000, 1_100_000, 1_140_000, 1_180_000]


def test_a_late_frame_of_another_source_is_news_to_the_line_arbiter(monkeypatch: pytest.MonkeyPatch) -> None:
    """The arbiter ignores what is older than what it knows: an open e-stop is told with the newest frame's time."""
    tool = examine_text(TWO_LINKS, "tool.yaml").description
    assert tool
    told: list[tuple[bool, int]] = []
    publisher = PredicatePublisher(tool, clock=lambda: 1_100_000)
    monkeypatch.setattr(
        publisher._sender, "send", lambda said, at: told.append((said["e_stop_closed"], at)) or True
    )
    publisher.frame(Frame(1_000_000, None, None, {"stop": True}))
    publisher.frame(Frame(1_100_000, None, None, {"cup": -70_000}))
    publisher.frame(Frame(1_040_000, None, None, {"stop": False}))
    assert told == [(True, 1_000_000), (True, 1_100_000), (False, 1_100_000)]


def test_what_was_refused_is_part_of_what_a_segment_begins_with(description: Description) -> None:
    codec = get_codec(description.link.codec)
    senses, restored = SensorSet(description, codec), SensorSet(description, codec)
    senses.accepts(Frame(NOW, None, None, {}), NOW)
    senses.accepts(Frame(NOW + 1, None, None, {}), NOW)
    recall(restored, memory_of(senses))
    assert (restored.stamps.refused, restored.stamps.notices(NOW)) == (1, senses.stamps.notices(NOW))
    assert not restored.accepts(Frame(NOW - 1, None, None, {}), NOW), "it is before the one that came last"


def test_detectors_ask_for_the_stamp_first(description: Description) -> None:
    senses = SensorSet(description, get_codec(description.link.codec))
    assert not senses.accepts(Frame(NOW + 1, None, None, {}), NOW)
    assert senses.accepts(Frame(NOW, None, None, {}), NOW)
    assert senses.stamps.refused == 1
    assert senses.deadline(NOW) == NOW + 10_000_000
    assert senses.stamps.notices(NOW) == (refused("stamped ahead of now"),)
