"""Where a noisy signal is going: lines by least squares."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from math import log, sqrt
from typing import ClassVar

Point = tuple[float, float]
BINS = 20
SURE = 3.0
"""A slope counts when it is so many of its own standard errors away from zero."""
ALMOST = 0.99
"""A fall that goes on with this share of its speed, or more, is a straight one."""


class Trend:
    """A signal over a window of time, as the means of short bins.

    A line is fitted to each half of the window. The signal falls when both halves do: noise does not look like a
    fall, nor does a step. A fall that slows down is taken to go on slowing down, as a vacuum does on its way to
    the level at which the ejector keeps up with a leak.

    Args:
        window_us: how much of the past counts.
        period_us: of the samples; where they are rare the window is longer, ten samples at least.
    """

    MEMORY: ClassVar = {
        "_points": deque[Point],
        "_samples": list[tuple[int, float]],
        "_older": float,
        "_newer": float,
    }

    def __init__(self, window_us: int, period_us: int) -> None:
        self._window_us = max(window_us, 10 * period_us)
        # a bin is full when the next sample would be too late for it
        self._full_us = self._window_us // BINS - period_us
        self._points: deque[Point] = deque()
        self._samples: list[tuple[int, float]] = []
        self._older = self._newer = 0.0

    def take(self, value: float, at: int) -> bool:
        """One more sample at ``at`` µs; True when a bin is full and the trend was computed again."""
        self._samples.append((at, value))
        if at - self._samples[0][0] < self._full_us:
            return False
        count = len(self._samples)
        mean_s = sum([when for when, _ in self._samples]) / count / 1e6
        self._points.append((mean_s, sum([each for _, each in self._samples]) / count))
        self._samples.clear()
        while self._points[-1][0] - self._points[0][0] > self._window_us / 1e6:
            self._points.popleft()
        halves = self._halves()
        self._older, self._newer = map(_surely, halves) if halves else (0.0, 0.0)
        return True

    def clear(self) -> None:
        """Start again, after a gap."""
        self._points.clear()
        self._samples.clear()
        self._older = self._newer = 0.0

    @property
    def falls(self) -> float | None:
        """By how much it falls in a second; 0: it does not. None: not known yet, or only its newer half falls."""
        if self._halves() is None or self._newer < 0 <= self._older:
            return None
        return max(0.0, -self._newer)

    def falls_by(self, distance: float) -> float | None:
        """Seconds until it has fallen so far from where it is, or None: it does not."""
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
        """The older and the newer half of the window; None: too little of it is known."""
        span_s = self._points[-1][0] - self._points[0][0] if self._points else 0.0
        if span_s < 0.8 * self._window_us / 1e6:
            return None
        middle = self._points[0][0] + span_s / 2
        older = [point for point in self._points if point[0] <= middle]
        newer = [point for point in self._points if point[0] >= middle]
        return (older, newer) if min(len(older), len(newer)) >= 3 else None


def _surely(points: Sequence[Point]) -> float:
    """The slope of the line through some points; 0 when it may as well be level."""
    count = len(points)
    mean_x = sum([x for x, _ in points]) / count
    mean_y = sum([y for _, y in points]) / count
    spread = sum([(x - mean_x) ** 2 for x, _ in points])
    slope = sum([(x - mean_x) * (y - mean_y) for x, y in points]) / spread
    rest = sum([(y - mean_y - slope * (x - mean_x)) ** 2 for x, y in points])
    error = sqrt(rest / (count - 2) / spread)
    return slope if abs(slope) > SURE * error else 0.0
