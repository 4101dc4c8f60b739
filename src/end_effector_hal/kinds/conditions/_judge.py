"""Judges whether a condition holds: true, false, or unknown (None)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import count
from typing import ClassVar

from end_effector_hal.kinds.stanza import Condition
from end_effector_hal.signals import PART, ChannelReadings, Streak

_Asked = Callable[["_Sample"], bool | None]


class _Sample:
    """The input of a condition: the readings at one time, and the streaks of the parts that must last."""

    __slots__ = ("at", "readings", "seen", "streaks")

    def __init__(self, readings: ChannelReadings, at: int, seen: list[int], streaks: list[Streak]) -> None:
        self.readings, self.at = readings, at
        self.seen, self.streaks = seen, streaks


class ConditionJudge:
    """Judges one condition and remembers how long each of its lasting parts has held.

    A sample counts for a lasting part if the newest frame contained a channel of that part. Time alone makes readings
    stale and so unknown; it never makes a condition hold.
    """

    MEMORY: ClassVar = {"_streaks": PART, "_seen": list[int]}

    def __init__(self, condition: Condition) -> None:
        numbers = count()
        self._asked = _compiled(condition, numbers)
        self._streaks = [Streak() for _ in range(next(numbers))]
        self._seen = [0] * len(self._streaks)

    def sample(self, readings: ChannelReadings, at: int) -> bool | None:
        """Return whether the condition holds at ``at`` µs; None: unknown."""
        return self._asked(_Sample(readings, at, self._seen, self._streaks))

    def forget(self) -> None:
        """Reset the duration of every part."""
        for streak, seen_at in zip(self._streaks, self._seen, strict=True):
            streak.take(False, seen_at)


def _compiled(this: Condition, numbers: Iterator[int]) -> _Asked:
    """Return a condition as a function of a sample, because it never changes and each frame evaluates it."""
    at_once = _joined(this, [_compiled(each, numbers) for each in this.parts]) if this.parts else _read(this)
    if this.for_ms == 0 and this.samples == 1:
        return at_once
    index, samples, us, channels = next(numbers), this.samples, this.for_ms * 1000, this.channels

    def lasts(sample: _Sample) -> bool | None:
        value, streak = at_once(sample), sample.streaks[index]
        arrived = True in map(sample.readings.arrived, channels)
        if arrived:
            sample.seen[index] = sample.at
        if arrived or value is None:
            streak.take(value is True, sample.at)
        return None if value is None else streak.samples >= samples and streak.lasted(sample.seen[index], us)

    return lasts


def _joined(this: Condition, parts: list[_Asked]) -> _Asked:
    """Return a function that combines the parts by Kleene's three-valued logic.

    It evaluates every part, even if one alone decides, because each part has its own memory.
    """
    if this.not_ is not None:
        (part,) = parts
        return lambda sample: None if (value := part(sample)) is None else not value
    decides = not this.all  # true decides `any`, false decides `all`

    def joined(sample: _Sample) -> bool | None:
        values = [part(sample) for part in parts]
        return decides if decides in values else None if None in values else not decides

    return joined


def _read(this: Condition) -> _Asked:
    channel = this.on or this.channel
    if this.on is not None:
        return lambda sample: (
            None if (value := sample.readings.get(channel, sample.at)) is None else bool(value)
        )
    low, high = this.span
    closed = this.between_kpa is not None or this.between is not None

    def passes(sample: _Sample) -> bool | None:
        value = sample.readings.get(channel, sample.at)
        if value is None or isinstance(value, bool):
            return None  # a bit has no thresholds
        measured = value / 1000  # kPa of Pa, or units of thousandths
        return low <= measured <= high if closed else low < measured < high

    return passes
