"""The watch over one vacuum while a part is held: a weak grip, a leak."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from end_effector_hal.kinds import AlarmKind, ChannelReadings, HoldFinding
from end_effector_hal.kinds.stanza import Hold
from end_effector_hal.signals import PART, Streak, Trend
from end_effector_hal.vocabulary import to_us

from ._detector import SecureDetector
from ._stanza import VacuumActuator

LASTS = 0.25
"""A leak is believed when it has been seen for this share of the window."""
RELIEF = 1.5
"""A leak is over when the loss has been this much farther away than what raises the alarm for a whole window."""


class VacuumWatch:
    """What is known of one vacuum circuit; what reads no pressure (a bit) is secure while it is on."""

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
        """Look at the newest reading, at ``at`` µs."""
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

    def findings(self, who: str, since: int, at: int) -> Iterator[HoldFinding]:
        """A weak grip and a leak, each when it is there and when it has ended."""
        if self.kpa is not None:
            yield from self._weak(who, self.kpa, since, at)
            yield from self._leak(who, self.kpa, at)

    @property
    def leak_kpa_s(self) -> float | None:
        """By how much the vacuum falls in a second; None: not known."""
        return self.trend.falls

    @property
    def lost_in_s(self) -> float | None:
        """Until it is under the threshold of loss."""
        return None if self.kpa is None else self.trend.falls_by(self.kpa - self._part.lost_kpa)

    def dropped(self) -> None:
        """What comes next is no trend of what was held."""
        self.trend.clear()

    def _expire(self) -> None:
        self.kpa, self.judged = None, False
        self._detector.expire()
        self.trend.clear()
        self.leaks, self.keeps = Streak(), Streak()

    def _weak(self, who: str, kpa: float, since: int, at: int) -> Iterator[HoldFinding]:
        within_s = self._hold.secure_within_s
        if self.secure:
            self.was_secure = True
            text = f"{who} was not secure for a while; it is again ({kpa:.0f} kPa)."
            yield HoldFinding(AlarmKind.WEAK, text, over=True)
        elif self.was_secure:
            least_kpa = self._detector.least_kpa
            text = f"Weak grip: {who} fell to {kpa:.1f} kPa; minimum for a secure grip: {least_kpa:g} kPa."
            yield HoldFinding(AlarmKind.WEAK, text)
        elif at - since >= to_us(within_s):
            missed = f"did not reach {self._part.secure_kpa:g} kPa within {within_s:g} s"
            yield HoldFinding(AlarmKind.WEAK, f"Weak grip: {who} {missed} ({kpa:.1f} kPa).")

    def _leak(self, who: str, kpa: float, at: int) -> Iterator[HoldFinding]:
        if not self.judged:
            return
        hold, lost_kpa = self._hold, self._part.lost_kpa
        left_s = self.trend.falls_by(kpa - lost_kpa)
        self.leaks.take(left_s is not None and left_s < hold.warn_ahead_s, at)
        self.keeps.take(left_s is None or left_s >= RELIEF * hold.warn_ahead_s, at)
        if self.keeps.lasted(at, to_us(hold.trend_s)):
            text = f"{who} leaked for a while; it is at {kpa:.0f} kPa now."
            yield HoldFinding(AlarmKind.LEAK, text, over=True)
        elif (falls := self.trend.falls) and left_s is not None and self._believed(at):
            fall = f"falls by {falls:.1f} kPa/s from {kpa:.1f} kPa"
            text = f"Leak: {who} {fall} and would be lost (under {lost_kpa:g} kPa) in {left_s:.0f} s."
            yield HoldFinding(AlarmKind.LEAK, text)

    def _believed(self, at: int) -> bool:
        return self.leaks.lasted(at, to_us(LASTS * self._hold.trend_s))
