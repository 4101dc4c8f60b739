"""Thresholds, hysteresis, consecutive samples and staleness, exact."""

from __future__ import annotations

import pytest

from end_effector_hal.codecs import get_codec
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.sensing import Predicates, SensorSet
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import Evidence, ToolEvidence

PERIOD = 20_000


class Feed:
    """Frames at 50 Hz into the detectors of the shipped tool."""

    def __init__(self, description: Description, codec: str = "ees1-ascii") -> None:
        self.codec = get_codec(codec)
        self.senses = SensorSet(description, self.codec)
        self.at = 1_000_000
        self.tool = False  # whether to tell the events of the tool changer
        bits = {"locked": True, "unlocked": False, "tool_present": True}
        bits |= {"cylinder_extended": False, "cylinder_retracted": True}
        self.values: dict[str, int | bool | None] = {
            "bottom": 0, "cylinder": 0, "top": 0, "supply": 600_000, **bits
        }  # fmt: skip

    def __call__(self, frames: int = 1, **values: int | bool | None) -> list[str]:
        self.values |= values
        said = []
        for _ in range(frames):
            self.at += PERIOD
            said += [event.channel for event in self.senses.frame(Frame(self.at, None, None, self.values))]
        return [channel for channel in said if self.tool or not channel.startswith("tool")]


@pytest.fixture
def feed() -> Feed:
    return Feed(load(profile_path()))


def test_everything_is_unknown_before_the_first_frame(feed: Feed) -> None:
    assert feed.senses.now.evidence == (Evidence.UNKNOWN,) * 3
    assert feed.senses.now.tool is ToolEvidence.UNCLEAR
    assert not feed.senses.conclusive


def test_vacuum_is_confirmed_by_three_samples_at_55_kpa(feed: Feed) -> None:
    assert feed() == ["partial[1]", "gone[0]", "gone[2]"]
    assert feed(bottom=-54_999) == ["partial[0]"]
    assert feed(2, bottom=-55_000) == []
    assert feed(bottom=-55_000) == ["confirmed[0]"]


def test_one_sample_in_between_starts_the_count_again(feed: Feed) -> None:
    feed()
    feed(2, bottom=-60_000)
    assert feed(bottom=-54_000) == []
    assert feed(2, bottom=-60_000) == []
    assert feed(bottom=-60_000) == ["confirmed[0]"]


def test_confirmed_vacuum_is_lost_by_two_samples_under_50_or_one_under_20(feed: Feed) -> None:
    feed(4, bottom=-60_000)
    feed(12, bottom=-50_000)  # held by its hysteresis; the cylinder settles meanwhile
    assert feed(bottom=-49_999) == []
    assert feed(bottom=-50_000) == []
    assert feed(bottom=-49_999) == []
    assert feed(bottom=-49_999) == ["partial[0]"]
    feed(4, bottom=-60_000)
    assert feed(bottom=-19_999) == ["partial[0]"]
    feed(4, bottom=-60_000)
    assert feed(bottom=-9_999) == ["gone[0]"]


def test_cylinder_is_extended_by_85_percent_of_supply_for_100_ms(feed: Feed) -> None:
    feed(12)
    assert feed(cylinder=509_999, cylinder_retracted=False) == ["partial[1]"]
    assert feed(5, cylinder=510_000) == []
    assert feed(cylinder=510_000) == ["confirmed[1]"]


def test_cylinder_is_extended_by_its_position_bit_at_once(feed: Feed) -> None:
    feed(12)
    assert feed(cylinder_extended=True) == ["confirmed[1]"]


def test_cylinder_is_retracted_under_50_kpa_for_200_ms(feed: Feed) -> None:
    feed(12, cylinder=600_000)
    assert feed(10, cylinder=49_999) == ["partial[1]"]
    assert feed(cylinder=49_999) == ["gone[1]"]


def test_of_one_frame_what_is_undone_is_told_before_what_is_confirmed(feed: Feed) -> None:
    feed(4, bottom=-60_000, top=-60_000)
    feed(12)
    assert feed(bottom=0, top=-15_000, cylinder_extended=True) == ["partial[2]", "gone[0]", "confirmed[1]"]


def test_a_reading_is_stale_after_150_ms_and_never_the_last_value(feed: Feed) -> None:
    feed.tool = True
    feed(12, bottom=-60_000)
    assert feed.senses.now.evidence[0] is Evidence.CONFIRMED
    due = feed.senses.deadline(feed.at)
    assert due == feed.at + 150_000
    assert feed.senses.advance(due - 1) == []
    said = [event.channel for event in feed.senses.advance(due)]
    assert said == ["stale[0]", "stale[1]", "stale[2]", "tool_is[0]"]
    assert feed.senses.now.evidence == (Evidence.UNKNOWN,) * 3


def test_an_invalid_channel_is_stale_alone_and_is_no_sample(feed: Feed) -> None:
    feed(12)
    feed(2, bottom=-60_000)
    assert feed(7, bottom=None) == []  # two samples and seven frames without one: not confirmed
    assert feed(bottom=None) == ["stale[0]"]
    assert feed.senses.now.evidence == (Evidence.UNKNOWN, Evidence.GONE, Evidence.GONE)


def test_what_was_confirmed_before_a_silence_is_confirmed_again_and_not_lost(feed: Feed) -> None:
    feed(12, bottom=-52_000)
    feed(4, bottom=-60_000, cylinder=600_000)
    feed(4)
    feed.senses.advance(feed.at + 150_000)
    feed.at += 200_000
    assert feed(5, bottom=-52_000) == ["gone[2]"]
    assert "confirmed[0]" in feed(), "as soon as the lock is proven again (100 ms)"
    assert "partial[1]" not in feed(3)


@pytest.mark.parametrize("il_05", [True, False])
def test_after_a_silence_nothing_is_confirmed_before_the_lock_is(il_05: bool) -> None:
    """Else the next activation is asked for when IL-05 still refuses it, and a short silence ends a grip."""
    shipped = load(profile_path())
    locks = shipped.interlocks.model_copy(update={"il_05": il_05})
    feed = Feed(shipped.model_copy(update={"interlocks": locks}))
    guard = Predicates(shipped, get_codec("ees1-ascii"))
    feed(12)
    feed.senses.advance(feed.at + 150_000)
    feed.at += 1_000_000
    feed.values["bottom"] = -80_000
    proven = []
    for _ in range(8):
        said = guard.frame(Frame(feed.at + PERIOD, None, None, feed.values))["locked"]
        proven.append((said, "confirmed[0]" in feed()))
    assert [said for said, _ in proven] == [False] * 5 + [True] * 3
    assert [confirmed for _, confirmed in proven].index(True) == (5 if il_05 else 2)


def test_bits_that_stay_away_do_not_keep_a_confirmation_back(feed: Feed) -> None:
    feed(12)
    feed.senses.advance(feed.at + 150_000)
    feed.at += 1_000_000
    feed(2, bottom=-80_000, locked=None, unlocked=None)
    assert "confirmed[0]" in feed()


def test_bits_that_contradict_each_other_do_not_either(feed: Feed) -> None:
    feed(12)
    feed.senses.advance(feed.at + 150_000)
    feed.at += 1_000_000
    feed(25, bottom=-80_000, unlocked=True)
    assert feed.senses.now.evidence[0] is Evidence.PARTIAL
    assert "confirmed[0]" in feed(1)
    assert feed.senses.now.tool is ToolEvidence.FAULTY


def test_what_fell_during_a_silence_is_lost_at_the_first_samples(feed: Feed) -> None:
    feed(12, bottom=-60_000)
    feed.senses.advance(feed.at + 150_000)
    feed.at += 200_000
    assert "gone[0]" in feed(bottom=0)


@pytest.mark.parametrize(("present", "shown"), [(False, "tool_is[4]"), (None, "tool_is[0]")])
def test_locked_needs_the_tool_where_a_sensor_shows_it(feed: Feed, present: bool | None, shown: str) -> None:
    feed(10)
    assert feed.senses.now.tool is ToolEvidence.LOCKED
    feed.tool = True
    assert shown in feed(10, tool_present=present)
    assert "tool_is[1]" in feed(10, tool_present=True)
    if present is not None:  # of an unlocked one nothing depends on it
        assert feed(10, tool_present=present, locked=False, unlocked=True) == ["tool_is[2]"]


def test_lock_is_proven_by_both_bits_for_100_ms(feed: Feed) -> None:
    feed.tool = True
    assert "tool_is[1]" not in feed(5)
    assert "tool_is[1]" in feed()
    feed(24, locked=False)
    assert feed.senses.now.tool is ToolEvidence.LOCKED
    assert feed(2, locked=False) == ["tool_is[3]"]


def test_supply_refuses_under_400_kpa_with_hysteresis(feed: Feed) -> None:
    feed(supply=400_000)
    assert feed.senses.now.supply.ok
    feed(supply=399_999)
    assert not feed.senses.now.supply.ok
    feed(supply=419_999)
    assert not feed.senses.now.supply.ok
    feed(supply=420_000)
    assert feed.senses.now.supply.ok


def test_booleans_of_the_prototype_work_under_the_same_rules() -> None:
    feed = Feed(load(profile_path()), "legacy-nibble")
    feed.values = {
        "locked": True,
        "unlocked": False,
        "bottom": False,
        "top": False,
        "cylinder_extended": False,
    }
    assert feed.senses.now.readings.stale_us == 3_000_000
    assert feed.senses.now.readings.down_us == 7_000_000
    assert feed() == ["gone[0]", "gone[1]", "gone[2]"]
    assert feed(2, bottom=True) == ["partial[0]"]
    assert feed(bottom=True) == ["confirmed[0]"]
    assert feed(cylinder_extended=True) == ["confirmed[1]"]
    assert feed(cylinder_extended=False) == ["gone[1]"]


@pytest.mark.parametrize("supply", [None, True, False])
def test_without_a_pressure_of_the_supply_its_nominal_one_counts(feed: Feed, supply: bool | None) -> None:
    """A bit says that there is air, not how much: True is not 1 Pa."""
    feed(12, supply=supply)
    assert feed(12, cylinder=509_999, cylinder_retracted=False)[0] == "partial[1]"
    assert feed.senses.now.evidence[1] is Evidence.PARTIAL
    assert "confirmed[1]" in feed(6, cylinder=510_000)
