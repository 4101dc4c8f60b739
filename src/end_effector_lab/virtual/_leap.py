"""Frames between two events that would change nothing, and so need not be played one by one."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from end_effector_hal.description import Description
from end_effector_hal.sensing import FrameJudge
from end_effector_hal.signals import Value

from ._sources import StreamedLink

FEW, MOST = 6, 50
"""So many frames it is looked ahead at first: as long as a reading stays fresh; and as far as it pays later."""
LEAST = 3
"""Fewer frames are played: to look ahead takes as long."""
AGAIN_AFTER = 2, 6
"""After so many frames it is looked ahead again, where something was going to change: at first, and later."""


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
        self._stays_until, self._look_at, self._ahead, self._again = -1, self.link.due + 1, FEW, 0

    def next(self, at: int, limit: int) -> int:
        """µs of the frame that is played next, at or before ``limit`` or the next one that comes, after ``at``."""
        due, period = self.link.due, self.link.period_us
        if limit < due:
            return due
        if self._stays_until < due:
            if due < self._look_at:
                return due
            ahead = self._quiet(at)
            if ahead < LEAST:
                return due
            if not self._stays(at, ahead):
                self._look_at, self._ahead = due + AGAIN_AFTER[self._again] * period, FEW
                self._again = 1
                return due
            self._stays_until = due + (ahead - 1) * period
            self._ahead, self._again = MOST if ahead == self._ahead else FEW, 0
        return due + (min(limit, self._stays_until) - due) // period * period

    def covers(self, at: int) -> bool:
        """Whether the frame of ``at`` µs itself changes nothing."""
        return at <= self._stays_until

    def _quiet(self, at: int) -> int:
        """How many of the next frames come before anything happens by itself."""
        until, first = self.link.quiet_until(at), self.link.due
        return self._ahead if until is None else min(self._ahead, (until - first) // self.link.period_us + 1)

    def _stays(self, at: int, ahead: int) -> bool:
        """Whether so many of the next frames change nothing."""
        first, period = self.link.due, self.link.period_us
        corners = self.link.corners(at, first + (ahead - 1) * period)
        return corners is not None and self._judge().stays(self._apart(*corners), first, period, ahead)

    def _apart(self, low: Mapping[str, Value], high: Mapping[str, Value]) -> tuple[Mapping[str, Value], ...]:
        """The least with the most supply, and the reverse: a pressure is compared with it."""
        if self._supply not in low:
            return low, high
        return {**low, self._supply: high[self._supply]}, {**high, self._supply: low[self._supply]}
