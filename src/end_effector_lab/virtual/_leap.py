"""Skips frames between two events that would change nothing."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from end_effector_hal.description import Description
from end_effector_hal.signals import Value

from ._sources import StreamedLink

FEW, MOST = 6, 50
"""Number of frames to look ahead: at first (as long as a reading stays fresh), and later at most."""
LEAST = 3
"""Smallest number of skipped frames; for fewer, looking ahead takes as long as playing them."""
AGAIN_AFTER = 2, 6
"""Number of frames before the next look ahead if a change is expected: at first, and later."""


class Leap:
    """Decides which frame of a tool's only link is played next; see `end_effector_hal.sensing.stays`.

    Args:
        description: the description of the tool.
        link: the link with the readings.
        stays: returns whether frames, given by their corners, the time of the first one, the period and their number,
            change nothing for the program.
    """

    def __init__(self, description: Description, link: StreamedLink, stays: Callable[..., bool]) -> None:
        self.link, self._changes_nothing, self._supply = link, stays, description.supply.channel
        self.forget()

    def forget(self) -> None:
        """Play the next frame, because the measured values or the receivers change."""
        self._stays_until, self._look_at, self._ahead, self._again = -1, self.link.due + 1, FEW, 0

    def next(self, at: int, limit: int) -> int:
        """Return the time of the next played frame, µs: at or before ``limit``, or the next frame after ``at``."""
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
        """Return whether the frame at ``at`` µs changes nothing."""
        return at <= self._stays_until

    def _quiet(self, at: int) -> int:
        """Return the number of next frames before anything happens by itself."""
        until, first = self.link.quiet_until(at), self.link.due
        return self._ahead if until is None else min(self._ahead, (until - first) // self.link.period_us + 1)

    def _stays(self, at: int, ahead: int) -> bool:
        """Return whether the next ``ahead`` frames change nothing."""
        first, period = self.link.due, self.link.period_us
        corners = self.link.corners(at, first + (ahead - 1) * period)
        return corners is not None and self._changes_nothing(self._apart(*corners), first, period, ahead)

    def _apart(self, low: Mapping[str, Value], high: Mapping[str, Value]) -> tuple[Mapping[str, Value], ...]:
        """Return the lowest values with the highest supply, and the reverse, since pressures are compared with the
        supply.
        """
        if self._supply not in low:
            return low, high
        return {**low, self._supply: high[self._supply]}, {**high, self._supply: low[self._supply]}
