"""A frame that nobody remembers is read as one that is taken."""

from __future__ import annotations

from end_effector_hal.codecs import carrier_of
from end_effector_hal.description import load, profile_path
from end_effector_hal.sensing import Readings
from end_effector_hal.signals import Frame, PassingReadings


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
