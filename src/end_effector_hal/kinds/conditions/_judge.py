"""Whether a condition holds: true, false, or unknown (None)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import count
from typing import ClassVar

from end_effector_hal.kinds.stanza import Condition
from end_effector_hal.signals import PART, ChannelReadings, Streak

_Asked = Callable[["_Sample"], bool | None]


class _Sample:
    """What a condition is asked of: readings at a time, and the streaks of those that must last."""

    __slots__ = ("at", "readings", "seen", "streaks")

    def __init__(self, readings: ChannelReadings, at: int, seen: list[int], streaks: list[Streak]) -> None:
        self.readings, self.at = readings, at
        self.seen, self.streaks = seen, streaks


class ConditionJudge:
    """One condition with its memory: how long each part of it that must last has held.

    A sample counts for a part that must last when the newest frame brought a channel of that part. Time alone makes
    readings stale, and so unknown; it never makes a condition hold.
    """

    MEMORY: ClassVar = {"_streaks": PART, "_seen": list[int]}

    def __init__(self, condition: Condition) -> None:
        numbers = count()
        self._asked = _compiled(condition, numbers)
        self._streaks = [Streak() for _ in range(next(numbers))]
        self._seen = [0] * len(self._streaks)

    def sample(self, readings: ChannelReadings, at: int) -> bool | None:
        """Whether it holds at ``at`` µs."""
        return self._asked(_Sample(readings, at, self._seen, self._streaks))

    def forget(self) -> None:
        """What has held until now counts no longer."""
        for streak, seen_at in zip(self._streaks, self._seen, strict=True):
            streak.take(False, seen_at)


def _compiled(this: Condition, numbers: Iterator[int]) -> _Asked:
    """A function of a sample: conditions are looked at with each frame, and never change."""
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
    """Kleene's three-valued logic. Every part is asked, also where one decides: each has a memory of its own."""
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
