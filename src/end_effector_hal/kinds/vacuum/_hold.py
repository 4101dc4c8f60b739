"""Watches one vacuum while a part is held, for a weak grip and for a leak."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from end_effector_hal.kinds import ChannelReadings, HoldFinding
from end_effector_hal.kinds.stanza import Hold
from end_effector_hal.signals import PART, Streak, Trend
from end_effector_hal.vocabulary import LEAK, WEAK, to_us

from ._detector import SecureDetector
from ._stanza import VacuumActuator

LASTS = 0.25
"""Share of the trend window for which a leak must be seen before it is reported."""
RELIEF = 1.5
"""A leak is over if for a whole window the loss was at least this factor times ``warn_ahead_s`` away."""


class VacuumWatch:
    """Watches one vacuum circuit; one with a bit instead of a pressure is secure while the bit is on."""

    MEMORY: ClassVar = {
        "_detector": PART,
        "trend": PART,
        "leaks": PART,
        "keeps": PART,
        "kpa": float | None,
        "secure": bool,
        "was_secure": bool,
        "judged": bool,
    }

    def __init__(self, part: VacuumActuator, hold: Hold, period_us: int) -> None:
        self._part, self._hold = part, hold
        self._detector = SecureDetector(part)
        self.trend = Trend(to_us(hold.trend_s), period_us)
        self.leaks, self.keeps = Streak(), Streak()
        self.kpa: float | None = None
        self.secure = self.was_secure = self.judged = False

    def sample(self, readings: ChannelReadings, at: int, *, held: bool) -> None:
        """Process the newest reading, at ``at`` µs."""
        value = readings.get(self._part.channel, at)
        if value is None or isinstance(value, bool):
            self._expire()
            self.secure = value is True
        elif readings.arrived(self._part.channel):
            self.kpa = -value / 1000
            self.secure = self._detector.sample(self.kpa, at)
            if held:
                self.judged = self.trend.take(self.kpa, at)
            else:
                self.was_secure = False
                self.trend.clear()

    def findings(self, since: int, at: int) -> Iterator[HoldFinding]:
        """Yield findings about a weak grip and a leak, both while present and when ended."""
        if self.kpa is not None:
            yield from self._weak(self.kpa, since, at)
            yield from self._leak(self.kpa, at)

    @property
    def leak_kpa_s(self) -> float | None:
        """Fall of the vacuum, kPa/s; None: not known."""
        return self.trend.falls

    @property
    def lost_in_s(self) -> float | None:
        """Time until the vacuum is below the threshold of loss, s; None: never, or not known."""
        return None if self.kpa is None else self.trend.falls_by(self.kpa - self._part.lost_kpa)

    def dropped(self) -> None:
        """Discard the trend, because the next samples belong to another part."""
        self.trend.clear()

    def _expire(self) -> None:
        self.kpa, self.judged = None, False
        self._detector.expire()
        self.trend.clear()
        self.leaks, self.keeps = Streak(), Streak()

    def _weak(self, kpa: float, since: int, at: int) -> Iterator[HoldFinding]:
        within_s = self._hold.secure_within_s
        if self.secure:
            self.was_secure = True
            yield HoldFinding(WEAK, {"kpa": kpa}, over=True)
        elif self.was_secure:
            yield HoldFinding(WEAK, {"kpa": kpa, "least_kpa": self._detector.least_kpa})
        elif at - since >= to_us(within_s):
            values = {"kpa": kpa, "secure_kpa": self._part.secure_kpa, "within_s": within_s}
            yield HoldFinding(WEAK, values)

    def _leak(self, kpa: float, at: int) -> Iterator[HoldFinding]:
        if not self.judged:
            return
        hold, lost_kpa = self._hold, self._part.lost_kpa
        left_s = self.trend.falls_by(kpa - lost_kpa)
        self.leaks.take(left_s is not None and left_s < hold.warn_ahead_s, at)
        self.keeps.take(left_s is None or left_s >= RELIEF * hold.warn_ahead_s, at)
        if self.keeps.lasted(at, to_us(hold.trend_s)):
            yield HoldFinding(LEAK, {"kpa": kpa}, over=True)
        elif (falls := self.trend.falls) and left_s is not None and self._believed(at):
            yield HoldFinding(LEAK, {"falls": falls, "kpa": kpa, "lost_kpa": lost_kpa, "left_s": left_s})

    def _believed(self, at: int) -> bool:
        return self.leaks.lasted(at, to_us(LASTS * self._hold.trend_s))
