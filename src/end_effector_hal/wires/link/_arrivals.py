"""How often readings come, against how often they should: lost samples, and devices slower than is declared."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection

from end_effector_hal.signals import Frame

WINDOW_US, PERIODS = 1_000_000, 20
"""It is counted so long, or for so many periods, the longer."""
LEAST, WELL = 2 / 3, 0.8
"""Two windows in a row with a smaller share are told; one with so much ends it."""
LONGEST_MS = 10_000


class ArrivalWatch:
    """Counts the valid readings of each channel; sans-IO.

    Args:
        channels: of the link.
        period_us: between two frames, nominally.
        declared: whether the description gives the period.
        asked: devices that are asked: a cycle may take longer, and only what is missing in it counts.
    """

    def __init__(self, channels: Collection[str], period_us: int, *, declared: bool, asked: bool) -> None:
        self._channels, self._period_us = frozenset(channels), period_us
        self._declared, self._asked = declared, asked
        self._since: int | None = None
        self._frames, self._came = 0, Counter[str]()
        self._few: frozenset[str] = frozenset()
        self._lossy: frozenset[str] = frozenset()
        self.text = ""
        """What is lost, a sentence in the words of its beginning; empty: nothing."""

    def take(self, frame: Frame) -> None:
        """One more frame."""
        if self._since is None:
            self._since = frame.at
            return
        self._frames += 1
        self._came.update(name for name, value in frame.values.items() if value is not None)
        span_us = frame.at - self._since
        if span_us >= max(WINDOW_US, PERIODS * self._period_us):
            self._judge(span_us)
            self._since, self._frames, self._came = frame.at, 0, Counter()

    def _judge(self, span_us: int) -> None:
        expected = self._frames if self._asked else span_us / self._period_us
        shares = {name: self._came[name] / expected for name in self._channels if self._came[name]}
        few = frozenset(name for name, share in shares.items() if share < LEAST)
        still = frozenset(name for name in self._lossy if shares.get(name, 0) < WELL)
        before, self._lossy, self._few = self._lossy, still | (few & self._few), few
        if self._lossy == before:
            return
        self.text = ""
        each_ms = round(span_us / self._frames / 1000)
        if self._lossy and not self._asked and self._lossy >= shares.keys():
            set_it = f": set period_ms: {each_ms}" if self._declared and each_ms <= LONGEST_MS else ""
            self.text = (
                f"A frame comes every {each_ms} ms, not every {self._period_us / 1000:g} ms. "
                f"Either samples are lost, or the device is slower{set_it}."
            )
        elif self._lossy:
            names = ", ".join(sorted(self._lossy))
            self.text = (
                f"More than a third of the samples of {names} are lost. Is a wire loose, or a sensor failing?"
            )
