"""What is watched while a part is held: a weak grip, a leak, lost readings, the supply. It never releases."""

from __future__ import annotations

from typing import ClassVar

from end_effector_hal.description import Description, VacuumActuator
from end_effector_hal.signals import PART, Streak, Trend
from end_effector_hal.vocabulary import Evidence, display_name, to_us

from ._alarms import AlarmKind, AlarmLog
from ._secure_detector import SecureDetector
from ._senses import Senses

LASTS = 0.25
"""A leak is believed when it has been seen for this share of the window."""
RELIEF = 1.5
"""A leak is over when the loss has been this much farther away than what raises the alarm for a whole window."""
KEPT = "outputs stay as they are, only a Drop releases"


class HoldMonitor:
    """Alarms about what is held; they stay until a Drop, or until they are over and acknowledged.

    What reads no pressure (a bit, a channel that is not carried) is watched for its readings only.

    Args:
        description: the tool.
        senses: its detectors, which have taken each sample before it is shown here.
        period_us: of the frames.
    """

    MEMORY: ClassVar = {"_log": PART, "_vacuums": PART, "_since": int | None}

    def __init__(self, description: Description, senses: Senses, period_us: int) -> None:
        self._description, self._senses, self._hold = description, senses, description.hold
        self._names = description.sequence
        self._log = AlarmLog()
        self._vacuums = {
            index: _Vacuum(part, description, period_us)
            for index, (_, part) in enumerate(description.ordered)
            if isinstance(part, VacuumActuator)
        }
        self._since: int | None = None

    @property
    def alarms(self) -> tuple[str, ...]:
        """In words."""
        return self._log.texts

    @property
    def secure(self) -> bool:
        """Whether everything is confirmed by a fresh reading and every vacuum is at its secure level."""
        return all(level is Evidence.CONFIRMED for level in self._senses.evidence) and all(
            vacuum.secure for vacuum in self._vacuums.values()
        )

    @property
    def allows_lift(self) -> bool:
        """Whether nothing that is watched speaks against lifting what is held and confirmed."""
        return not self._log.active(AlarmKind.LEAK) and (self._hold.lift_needs == "confirmed" or self.secure)

    def sample(self, at: int, *, held: bool) -> bool:
        """Look at the newest sample, at ``at`` µs; True when there is something new to tell."""
        before = (self.secure, self.alarms)
        for index, vacuum in self._vacuums.items():
            self._take(index, vacuum, at)
        if not held:
            self._since = None
        else:
            self._since = at if self._since is None else self._since
            for index, name in enumerate(self._names):
                self._readable(index, name, at)
            for index, vacuum in self._vacuums.items():
                if self._senses.evidence[index] is Evidence.CONFIRMED and vacuum.kpa is not None:
                    self._weak(index, vacuum, vacuum.kpa, at)
                    self._leak(index, vacuum, vacuum.kpa, at)
            self._supply(at)
        return (self.secure, self.alarms) != before

    def acknowledge(self) -> None:
        """An operator has seen it: what is over is forgotten, what is not stays."""
        self._log.acknowledge()

    def dropped(self) -> None:
        """A Drop was accepted: nothing is held any more."""
        self._log.clear()
        for vacuum in self._vacuums.values():
            vacuum.trend.clear()

    def _take(self, index: int, vacuum: _Vacuum, at: int) -> None:
        channel = vacuum.part.channel
        value = self._senses.readings.get(channel, at)
        if value is None or isinstance(value, bool):
            vacuum.expire()
            vacuum.secure = value is True
        elif self._senses.readings.arrived(channel):
            vacuum.take(-value / 1000, at, held=self._since is not None)

    def _readable(self, index: int, name: str, at: int) -> None:
        who = display_name(name)
        if self._senses.evidence[index] is Evidence.UNKNOWN:
            self._log.raise_(AlarmKind.STALE, name, f"No reading: {who} is held and not known; {KEPT}.", at)
        else:
            self._log.end(AlarmKind.STALE, name, f"{who} had no valid reading for a while; it is read again.")

    def _weak(self, index: int, vacuum: _Vacuum, kpa: float, at: int) -> None:
        name = self._names[index]
        who, part, since = display_name(name), vacuum.part, self._since or at
        if vacuum.secure:
            vacuum.was_secure = True
            self._log.end(
                AlarmKind.WEAK, name, f"{who} was not secure for a while; it is again ({kpa:.0f} kPa)."
            )
        elif vacuum.was_secure:
            text = f"Weak grip: {who} fell to {kpa:.1f} kPa, secure down to {vacuum.least_kpa:g} kPa."
            self._log.raise_(AlarmKind.WEAK, name, text, at)
        elif at - since >= to_us(self._hold.secure_within_s):
            within = f"within {self._hold.secure_within_s:g} s"
            text = f"Weak grip: {who} did not reach {part.secure_kpa:g} kPa {within} ({kpa:.1f} kPa)."
            self._log.raise_(AlarmKind.WEAK, name, text, at)

    def _leak(self, index: int, vacuum: _Vacuum, kpa: float, at: int) -> None:
        if not vacuum.judged:
            return
        name, part, trend = self._names[index], vacuum.part, vacuum.trend
        who, left_s = display_name(name), trend.falls_by(kpa - part.lost_kpa)
        vacuum.leaks.take(left_s is not None and left_s < self._hold.warn_ahead_s, at)
        vacuum.keeps.take(left_s is None or left_s >= RELIEF * self._hold.warn_ahead_s, at)
        if vacuum.keeps.lasted(at, to_us(self._hold.trend_s)):
            self._log.end(AlarmKind.LEAK, name, f"{who} leaked for a while; it is at {kpa:.0f} kPa now.")
        elif left_s is not None and vacuum.leaks.lasted(at, to_us(LASTS * self._hold.trend_s)):
            fall = f"falls by {trend.falls:.1f} kPa/s from {kpa:.1f} kPa"
            text = f"Leak: {who} {fall} and would be lost (under {part.lost_kpa:g} kPa) in {left_s:.0f} s."
            self._log.raise_(AlarmKind.LEAK, name, text, at)

    def _supply(self, at: int) -> None:
        supply, warn = self._senses.supply, f"{self._description.supply.warn_kpa:g} kPa"
        if supply.low and supply.kpa is not None:
            text = f"Low supply: under {warn} while a part is held ({supply.kpa:.0f} kPa)."
            self._log.raise_(AlarmKind.SUPPLY, "", text, at)
        elif not supply.low:
            self._log.end(
                AlarmKind.SUPPLY, "", f"The supply pressure was under {warn} while a part was held."
            )


class _Vacuum:
    """What is known of one vacuum circuit."""

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

    def __init__(self, part: VacuumActuator, description: Description, period_us: int) -> None:
        self.part = part
        self._detector = SecureDetector(part)
        self.trend = Trend(to_us(description.hold.trend_s), period_us)
        self.leaks, self.keeps = Streak(), Streak()
        self.kpa: float | None = None
        self.secure = self.was_secure = self.judged = False

    @property
    def least_kpa(self) -> float:
        return self._detector.least_kpa

    def take(self, kpa: float, at: int, *, held: bool) -> None:
        self.kpa = kpa
        self.secure = self._detector.sample(kpa, at)
        if held:
            self.judged = self.trend.take(kpa, at)
        else:
            self.was_secure = False
            self.trend.clear()

    def expire(self) -> None:
        self.kpa, self.judged = None, False
        self._detector.expire()
        self.trend.clear()
        self.leaks, self.keeps = Streak(), Streak()
