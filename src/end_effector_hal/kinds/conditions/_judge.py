"""Whether a condition holds: true, false, or unknown (None)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from end_effector_hal.kinds.stanza import Condition
from end_effector_hal.signals import PART, ChannelReadings, Streak


class ConditionJudge:
    """One condition with its memory: how long each part of it that must last has held.

    A sample counts when the newest frame brought a channel of it. Time alone makes readings stale, and so unknown;
    it never makes a condition hold.
    """

    MEMORY: ClassVar = {"_streaks": PART, "_at": int}

    def __init__(self, condition: Condition) -> None:
        self._condition = condition
        self._channels = condition.channels
        self._streaks = [Streak() for _ in range(_lasting(condition))]
        self._at = 0

    def sample(self, readings: ChannelReadings, at: int) -> bool | None:
        """Whether it holds at ``at`` µs."""
        arrived = any(map(readings.arrived, self._channels))
        if arrived:
            self._at = at
        return self._holds(self._condition, readings, at, arrived, iter(self._streaks))

    def forget(self) -> None:
        """What has held until now counts no longer."""
        for streak in self._streaks:
            streak.take(False, self._at)

    def _holds(
        self, this: Condition, readings: ChannelReadings, at: int, arrived: bool, streaks: Iterator[Streak]
    ) -> bool | None:
        # every part is looked at, also where one decides: each has a memory of its own
        value = _joined(this, [self._holds(each, readings, at, arrived, streaks) for each in this.parts])
        if not this.parts:
            value = _read(this, readings, at)
        if not _lasts(this):
            return value
        streak = next(streaks)
        if arrived or value is None:
            streak.take(value is True, at)
        if value is None:
            return None
        return streak.samples >= this.samples and streak.lasted(self._at, this.for_ms * 1000)


def _read(this: Condition, readings: ChannelReadings, at: int) -> bool | None:
    value = readings.get(this.on or this.channel, at)
    if value is None:
        return None
    if this.on is not None:
        return bool(value)
    if isinstance(value, bool):
        return None  # a bit has no pressure
    kpa = value / 1000
    if this.between_kpa is not None:
        low, high = this.between_kpa
        return low <= kpa <= high
    return kpa < this.below_kpa if this.below_kpa is not None else kpa > (this.above_kpa or 0.0)


def _joined(this: Condition, values: list[bool | None]) -> bool | None:
    """Kleene's three-valued logic."""
    if this.not_ is not None:
        return None if values[0] is None else not values[0]
    decides = not this.all  # true decides `any`, false decides `all`
    if decides in values:
        return decides
    return None if None in values else not decides


def _lasts(this: Condition) -> bool:
    return this.for_ms > 0 or this.samples > 1


def _lasting(this: Condition) -> int:
    return _lasts(this) + sum(map(_lasting, this.parts))
