"""Compares the rate of readings with the expected rate: detects lost samples, and devices slower than declared."""

from __future__ import annotations

from collections import Counter

from end_effector_hal.signals import Frame

WINDOW_US, PERIODS = 1_000_000, 20
"""Length of a counting window: the longer of ``WINDOW_US`` and this number of periods."""
LEAST = 2 / 3
"""Least share of the expected samples of a channel. Two consecutive windows below it start an alarm; one window that
reaches it ends the alarm.
"""
LONGEST_MS = 10_000


class ArrivalWatch:
    """Counts the valid readings of each channel; sans-IO.

    Args:
        period_us: nominal time between two frames.
        declared: whether the description gives the period.
        asked: whether the devices are polled: a cycle may then take longer, and only readings missing in a frame
            count.
    """

    def __init__(self, period_us: int, *, declared: bool, asked: bool) -> None:
        self._period_us, self._declared, self._asked = period_us, declared, asked
        self._since, self._frames, self._came = -1, 0, Counter[str]()
        self._few, self._lossy = frozenset[str](), frozenset[str]()
        self.text = ""
        """The present loss, as a sentence that stays as it was at the start of the alarm; empty: no loss."""

    def take(self, frame: Frame) -> None:
        """Count one more frame."""
        span_us = frame.at - self._since
        if self._since >= 0:
            self._frames += 1
            self._came.update([name for name, value in frame.values.items() if value is not None])
            if span_us < max(WINDOW_US, PERIODS * self._period_us):
                return
            self._judge(span_us)
        self._since, self._frames, self._came = frame.at, 0, Counter()

    def _judge(self, span_us: int) -> None:
        expected = self._frames if self._asked else span_us / self._period_us
        few = frozenset(name for name, count in self._came.items() if count < LEAST * expected)
        before, self._lossy, self._few = self._lossy, few & self._few, few
        if self._lossy == before:
            return
        each_ms, names = round(span_us / self._frames / 1000), ", ".join(sorted(self._lossy))
        self.text = names and f"More than a third of the samples of {names} are lost: is a wire loose?"
        if names and not self._asked and self._lossy >= self._came.keys():
            fits = f": set period_ms: {each_ms}" if self._declared and each_ms <= LONGEST_MS else ""
            expected_ms = f"{self._period_us / 1000:g} ms"
            self.text = (
                f"A frame comes every {each_ms} ms, not every {expected_ms}. "
                f"Either samples are lost, or the device is slower{fits}."
            )
