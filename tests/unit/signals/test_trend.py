"""Where a noisy signal is going, and a frame that nobody remembers."""

from __future__ import annotations

import math
from collections.abc import Callable
from random import Random

import pytest

from end_effector_hal.codecs import carrier_of
from end_effector_hal.description import load, profile_path
from end_effector_hal.sensing import Readings
from end_effector_hal.signals import Frame, PassingReadings
from end_effector_hal.signals._trend import Trend

PERIOD = 20_000


def fed(signal: Callable[[float], float], seconds: float, noise: float = 0.0, period: int = PERIOD) -> Trend:
    trend, random = Trend(2_000_000, period), Random(7)
    for at in range(0, round(seconds * 1e6), period):
        trend.take(signal(at / 1e6) + random.gauss(0.0, noise), at)
    return trend


def test_a_straight_fall_is_told_exactly() -> None:
    trend = fed(lambda s: 80.0 - 3.0 * s, 2.5)
    assert trend.falls == pytest.approx(3.0)
    assert trend.falls_by(15.0) == pytest.approx(5.0)
    assert trend.falls_by(-1.0) == 0.0


@pytest.mark.parametrize("noise", [0.1, 0.5])
def test_noise_changes_it_little(noise: float) -> None:
    assert fed(lambda s: 80.0 - 3.0 * s, 2.5, noise).falls == pytest.approx(3.0, rel=0.2)


def test_a_fall_that_slows_down_ends_where_it_is_going() -> None:
    """From 85 to 65 kPa with a time constant of 1 s: after 2.5 s it is at 66.6 and never comes to 60."""
    trend = fed(lambda s: 65.0 + 20.0 * math.exp(-s), 2.5)
    assert trend.falls
    assert trend.falls_by(6.6) is None
    expected = -math.log(0.6 / 1.64)  # from 1.64 kPa above its end to 0.6 above it
    assert trend.falls_by(1.04) == pytest.approx(expected, rel=0.15)


def test_nothing_is_known_before_the_window_is_nearly_full() -> None:
    assert fed(lambda s: 80.0 - 3.0 * s, 1.5).falls is None
    assert fed(lambda s: 80.0 - 3.0 * s, 1.9).falls == pytest.approx(3.0)


@pytest.mark.parametrize("level", [50.5, 60.0, 85.0])
def test_noise_alone_is_no_fall_that_would_matter(level: float) -> None:
    trend, random = Trend(2_000_000, PERIOD), Random(3)
    for at in range(0, 120_000_000, PERIOD):
        if trend.take(level + random.gauss(0.0, 0.1), at):
            assert (trend.falls or 0.0) < 0.3


def test_a_rise_is_no_fall() -> None:
    assert fed(lambda s: 60.0 + 3.0 * s, 2.5).falls_by(1.0) is None


def test_a_fall_that_has_just_begun_is_not_taken_for_none() -> None:
    """Its older half rises or is level: whether the newer one is a step or a fall is not known."""
    assert fed(lambda s: 80.0, 2.5).falls == 0.0
    assert fed(lambda s: 80.0 - max(0.0, 3.0 * (s - 2.0)), 2.5).falls is None


def test_a_step_is_no_fall_before_or_after_it_crosses_the_middle() -> None:
    for moment in (0.3, 1.5, 2.2):
        assert fed(lambda s, moment=moment: 85.0 if s < moment else 65.0, 2.5, 0.1).falls_by(15.0) is None


def test_after_a_gap_it_begins_anew() -> None:
    trend = fed(lambda s: 80.0 - 3.0 * s, 2.5)
    trend.clear()
    assert trend.falls is None
    assert trend.falls_by(1.0) is None


def test_rare_samples_make_the_window_longer() -> None:
    assert fed(lambda s: 80.0 - s, 5.0, period=1_000_000).falls is None
    assert fed(lambda s: 80.0 - s, 12.0, period=1_000_000).falls == pytest.approx(1.0)


# A frame that nobody remembers is read as one that is taken.


def test_an_invalid_value_refreshes_nothing_and_what_was_read_stays_until_it_is_stale() -> None:
    description = load(profile_path())
    readings = Readings(description, carrier_of(description))
    readings.take(Frame(0, 0, 0, {"top": -60_000, "bottom": -50_000}))
    for at in (20_000, 140_000, 150_000, 160_000):
        frame = Frame(at, 1, 0, {"top": None, "bottom": -40_000})
        passing = PassingReadings(readings, frame)
        assert passing.get("top", at) == readings.get("top", at) == (-60_000 if at < 150_000 else None)
        assert passing.fresh.get("top") == passing.get("top", at)
        assert passing.arrived == {"bottom"}
        assert passing.get("bottom", at) == -40_000
