"""Frames between two events that would change nothing, and so need not be played one by one."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from end_effector_hal.description import Description
from end_effector_hal.sensing import FrameJudge
from end_effector_hal.signals import Value

from ._sources import StreamedLink

SHORT_US, LONG_US = 120_000, 1_000_000
"""So far it is looked ahead: as far as a reading stays fresh; and as far as it pays, where that came true."""
AGAIN_AFTER = 6
"""After so many frames it is looked ahead again, where that showed that something will change."""


class Leap:
    """Says which frame of the only link of a tool is to be played next; see `FrameJudge.stays`.

    Args:
        description: of the tool.
        link: that brings its readings.
        judge: of those who get them now.
    """

    def __init__(self, description: Description, link: StreamedLink, judge: Callable[[], FrameJudge]) -> None:
        self.link, self._judge, self._supply = link, judge, description.supply.channel
        self.forget()

    def forget(self) -> None:
        """Something happens to what is measured, or to those who get it: the next frame is played."""
        self._stays_until, self._look_at, self._ahead_us = 0, self.link.due + 1, SHORT_US

    def next(self, at: int, limit: int) -> int:
        """µs of the frame that is played next, at or before ``limit`` or the next one that comes, after ``at``."""
        due, period = self.link.due, self.link.period_us
        if limit < due + period:
            return due
        if self._stays_until < due + period:
            if due < self._look_at:
                return due
            self._stays_until = self._stays(at, self._ahead_us)
            self._ahead_us = LONG_US if self._stays_until and self._ahead_us == SHORT_US else SHORT_US
            if not self._stays_until:
                self._look_at = due + AGAIN_AFTER * period
                return due
        return due + (min(limit, self._stays_until) - due) // period * period

    def covers(self, at: int) -> bool:
        """Whether the frame of ``at`` µs itself changes nothing."""
        return at <= self._stays_until

    def _stays(self, at: int, us: int) -> int:
        """µs of the last frame that changes nothing, so far ahead; 0: one before it does."""
        first, more = self.link.due, us // self.link.period_us
        last = first + more * self.link.period_us
        corners = self.link.corners(at, last)
        if corners is None:
            return 0
        low, high = corners
        supply = {self._supply: high[self._supply]} if self._supply in high else {}
        other = {self._supply: low[self._supply]} if self._supply in low else {}
        every: tuple[Mapping[str, Value], ...] = (low, high, {**low, **supply}, {**high, **other})
        return last if self._judge().stays(every, first, last, more + 1) else 0
