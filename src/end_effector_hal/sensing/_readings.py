"""The newest reading of each channel, for as long as it is fresh."""

from __future__ import annotations

from typing import ClassVar

from end_effector_hal.codecs import Codec
from end_effector_hal.description import Link
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import to_us


class Readings:
    """Values by channel; a value that is stale or invalid is absent, never the last one.

    Stale after 150 ms or three periods of the link, down after 1 s or seven, whichever is longer.
    """

    MEMORY: ClassVar = {
        "_values": dict[str, int | bool],
        "_at": dict[str, int],
        "_last_frame": int | None,
        "_arrived": frozenset[str],
    }

    def __init__(self, link: Link, codec: Codec) -> None:
        self.carried = codec.channels
        self.stale_us = max(to_us(link.stale_s), link.stale_periods * codec.period_us)
        self.down_us = max(to_us(link.down_s), link.down_periods * codec.period_us)
        self._values: dict[str, int | bool] = {}
        self._at: dict[str, int] = {}
        self._last_frame: int | None = None
        self._arrived: frozenset[str] = frozenset()

    def take(self, frame: Frame) -> None:
        """Remember what a frame carries; an invalid value refreshes nothing."""
        self._last_frame = frame.at
        valid = {channel: value for channel, value in frame.values.items() if value is not None}
        self._values.update(valid)
        self._at.update(dict.fromkeys(valid, frame.at))
        self._arrived = frozenset(valid)

    def forget(self, channel: str | None = None) -> None:
        """What was read is nothing any more, of one channel or of all."""
        if channel is None:
            self._values.clear()
            self._at.clear()
            self._arrived = frozenset()
        elif channel in self._values:
            del self._values[channel], self._at[channel]

    def idle(self) -> None:
        """Time has passed and nothing came: what is remembered is no new sample."""
        self._arrived = frozenset()

    def arrived(self, channel: str) -> bool:
        """Whether the newest frame brought a valid value: only that is a sample to count."""
        return channel in self._arrived

    def get(self, channel: str | None, at: int) -> int | bool | None:
        """The value of a channel at a time in µs, or None: not carried, never read, or stale."""
        if channel is None or channel not in self._values or at - self._at[channel] >= self.stale_us:
            return None
        return self._values[channel]

    def stale(self, at: int) -> tuple[str, ...]:
        """Channels that the codec carries and that have no valid reading now."""
        oldest, read_at = at - self.stale_us, self._at
        return tuple([channel for channel in self.carried if read_at.get(channel, oldest) <= oldest])

    def fresh(self, at: int) -> bool:
        """Whether a frame has come so lately that what it carries is not stale."""
        return self._last_frame is not None and at - self._last_frame < self.stale_us

    def link_up(self, at: int) -> bool:
        """Whether a frame has come within the time after which the link is down."""
        return self._last_frame is not None and at - self._last_frame < self.down_us

    def deadline(self, at: int) -> int | None:
        """µs when the next reading turns stale or the link goes down, if nothing comes."""
        ends = {then + self.stale_us for then in self._at.values()}
        if self._last_frame is not None:
            ends.add(self._last_frame + self.down_us)
        return min([end for end in ends if end > at], default=None)
