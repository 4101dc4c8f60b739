"""Computes from vacuum samples the evidence and whether a grip is secure.

It uses thresholds, hysteresis and consecutive samples.
"""

from __future__ import annotations

from typing import ClassVar

from end_effector_hal.kinds import ChannelReadings, below_ambient_kpa
from end_effector_hal.signals import PART, Streak
from end_effector_hal.vocabulary import Evidence

from ._stanza import VacuumActuator


class VacuumDetector:
    """Judges one vacuum circuit as confirmed, partial or gone, from its pressure.

    A confirmed vacuum stays confirmed down to ``lost_kpa``, also across an interruption of the link: afterwards
    ``lost_kpa`` is enough to confirm it again, because a short silence must not look like a loss.
    """

    MEMORY: ClassVar = {"_held": bool, "_above": PART, "_below": PART, "level": Evidence}

    def __init__(self, actuator: VacuumActuator) -> None:
        self._actuator = actuator
        self._held = False
        self._above = Streak()
        self._below = Streak()
        self.level = Evidence.UNKNOWN

    def sample(self, readings: ChannelReadings, at: int) -> Evidence:
        """Return the evidence after one more sample at ``at`` µs."""
        value = readings.get(self._actuator.channel, at)
        if value is None:
            return self.expire()
        if not readings.arrived(self._actuator.channel):
            return self.level
        part = self._actuator
        kpa = below_ambient_kpa(value)
        self._above.take(kpa >= (part.lost_kpa if self._held else part.confirmed_kpa), at)
        self._below.take(kpa < part.lost_kpa, at)
        if self._held:
            if kpa < part.lost_at_once_kpa or self._below.samples >= part.lost_samples:
                self._held = False
            elif self._above.samples >= part.confirmed_samples:
                self.level = Evidence.CONFIRMED
        elif self._above.samples >= part.confirmed_samples:
            self._held = True
            self.level = Evidence.CONFIRMED
        if not self._held:
            self.level = Evidence.GONE if kpa < part.gone_kpa else Evidence.PARTIAL
        return self.level

    def expire(self) -> Evidence:
        """Return UNKNOWN and restart the counts, because no fresh reading is available."""
        self._above, self._below = Streak(), Streak()
        self.level = Evidence.UNKNOWN
        return self.level


class SecureDetector:
    """Judges whether a grip is secure: from ``secure_kpa`` on, until the hysteresis is used up.

    A single sample decides nothing.
    """

    MEMORY: ClassVar = {"_high": PART, "_low": PART, "secure": bool}

    def __init__(self, actuator: VacuumActuator) -> None:
        self._part = actuator
        self._high, self._low = Streak(), Streak()
        self.secure = False

    @property
    def least_kpa(self) -> float:
        """Limit below which a grip is no longer secure, kPa below ambient."""
        return self._part.secure_kpa - self._part.secure_hysteresis_kpa

    def sample(self, kpa: float, at: int) -> bool:
        """Return whether the grip is secure after one more sample, kPa below ambient, at ``at`` µs."""
        self._high.take(kpa >= self._part.secure_kpa, at)
        self._low.take(kpa < self.least_kpa, at)
        if self._high.samples >= self._part.confirmed_samples:
            self.secure = True
        elif self._low.samples >= self._part.lost_samples:
            self.secure = False
        return self.secure

    def expire(self) -> None:
        """Restart the counts, because no fresh reading is available.

        The last judgement stays until new samples change it.
        """
        self._high, self._low = Streak(), Streak()
