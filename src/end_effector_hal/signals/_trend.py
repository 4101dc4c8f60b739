"""The memory of detectors: streaks and trends.

A streak measures how long, and for how many samples, a condition has held. A trend is the slope of a noisy signal,
estimated with lines by least squares.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence
from math import log, sqrt
from typing import ClassVar

from end_effector_hal.signals._memory import Remembers, parts_of


class Streak:
    """Counts consecutive samples for which a condition holds, and stores the time of the first one.

    A detector without a time sets ``samples`` itself, without `take`: every frame counts several.
    """

    MEMORY: ClassVar = {"samples": int, "_since": int}

    def __init__(self) -> None:
        self.samples = 0
        self._since = 0

    def take(self, holds: bool, at: int) -> None:
        """Count one more sample, at ``at`` µs."""
        if not holds:
            self.samples = 0
        else:
            if self.samples == 0:
                self._since = at
            self.samples += 1

    def began_within(self, at: int, us: int) -> bool:
        """Return whether the last streak, running or ended, began less than this many µs ago."""
        return at - self._since < us

    def lasted(self, at: int, us: int) -> bool:
        """Return whether the condition has held without a break for at least this many µs."""
        return self.samples > 0 and at - self._since >= us


def streaks_of(thing: Remembers) -> list[Streak]:
    """Return all streaks of an object and of its parts."""
    if type(thing) is Streak:
        return [thing]
    found: list[Streak] = []
    for part in parts_of(thing):
        found += streaks_of(part)
    return found


def lengthen(streaks: Iterable[Streak], samples: int) -> None:
    """Add this number of samples to each streak that is running."""
    for streak in streaks:
        if streak.samples:
            streak.samples += samples


Point = tuple[float, float]
BINS = 20
SURE = 3.0
"""A slope counts if it is at least this many of its own standard errors away from zero."""
ALMOST = 0.99
"""A fall that keeps at least this share of its slope from the older to the newer half counts as straight."""


class Trend:
    """The trend of a signal over a window of time, computed from the means of short bins.

    A line is fitted to each half of the window. The signal falls if both halves fall: neither noise nor a step looks
    like that. A fall that slows down is expected to slow down further, like a vacuum that approaches the level at
    which the ejector compensates a leak.

    Args:
        window_us: length of the window, µs.
        period_us: period of the samples, µs; the window has at least ten periods.
    """

    MEMORY: ClassVar = {
        "points": deque[Point],
        "samples": list[tuple[int, float]],
        "_older": float,
        "_newer": float,
    }

    def __init__(self, window_us: int, period_us: int) -> None:
        self._window_us = max(window_us, 10 * period_us)
        # a bin is full when the next sample would be too late for it
        self._full_us = self._window_us // BINS - period_us
        self.points: deque[Point] = deque()
        self.samples: list[tuple[int, float]] = []
        self._older = self._newer = 0.0

    def take(self, value: float, at: int) -> bool:
        """Add one more sample at ``at`` µs; return True if a bin is full and the trend was computed again."""
        self.samples.append((at, value))
        if at - self.samples[0][0] < self._full_us:
            return False
        count = len(self.samples)
        mean_s = sum([when for when, _ in self.samples]) / count / 1e6
        self.points.append((mean_s, sum([each for _, each in self.samples]) / count))
        self.samples.clear()
        while self.points[-1][0] - self.points[0][0] > self._window_us / 1e6:
            self.points.popleft()
        halves = self._halves()
        self._older, self._newer = map(_surely, halves) if halves else (0.0, 0.0)
        return True

    def clear(self) -> None:
        """Discard all samples, after a gap."""
        self.points.clear()
        self.samples.clear()
        self._older = self._newer = 0.0

    @property
    def falls(self) -> float | None:
        """Fall of the signal per second; 0: none. None: not known yet, or only the newer half falls."""
        if self._halves() is None or self._newer < 0 <= self._older:
            return None
        return max(0.0, -self._newer)

    def falls_by(self, distance: float) -> float | None:
        """Return the time until the signal has fallen by this distance, s; None: it never does."""
        falls = self.falls
        if not falls:
            return None
        if distance <= 0:
            return 0.0
        slowing = self._newer / self._older
        if slowing > ALMOST:
            return distance / falls
        # the slope goes with slowing ** (t / half); that of the newer half is half of it old
        half_s, decay = self._window_us / 2e6, -log(slowing)
        left = 1 - distance * decay / (falls * sqrt(slowing) * half_s)
        return -log(left) / decay * half_s if left > 0 else None

    def _halves(self) -> tuple[list[Point], list[Point]] | None:
        """Return the points of both halves of the window, older first; None: it is not full enough."""
        span_s = self.points[-1][0] - self.points[0][0] if self.points else 0.0
        if span_s < 0.8 * self._window_us / 1e6:
            return None
        middle = self.points[0][0] + span_s / 2
        older = [point for point in self.points if point[0] <= middle]
        newer = [point for point in self.points if point[0] >= middle]
        return (older, newer) if min(len(older), len(newer)) >= 3 else None


def _surely(points: Sequence[Point]) -> float:
    """Return the slope of the line through some points; 0 if it does not differ from zero with certainty."""
    count = len(points)
    mean_x = sum([x for x, _ in points]) / count
    mean_y = sum([y for _, y in points]) / count
    spread = sum([(x - mean_x) ** 2 for x, _ in points])
    slope = sum([(x - mean_x) * (y - mean_y) for x, y in points]) / spread
    rest = sum([(y - mean_y - slope * (x - mean_x)) ** 2 for x, y in points])
    error = sqrt(rest / (count - 2) / spread)
    return slope if abs(slope) > SURE * error else 0.0
