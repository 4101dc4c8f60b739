"""From vacuum samples to whether a grip is secure: more than confirmed."""

from __future__ import annotations

from typing import ClassVar

from end_effector_hal.signals import PART, Streak

from ._stanza import VacuumActuator


class SecureDetector:
    """Secure from ``secure_kpa`` on, no longer when its hysteresis is used up; a single sample decides nothing."""

    MEMORY: ClassVar = {"_high": PART, "_low": PART, "secure": bool}

    def __init__(self, actuator: VacuumActuator) -> None:
        self._part = actuator
        self._high, self._low = Streak(), Streak()
        self.secure = False

    @property
    def least_kpa(self) -> float:
        """Less than this is no longer secure."""
        return self._part.secure_kpa - self._part.secure_hysteresis_kpa

    def sample(self, kpa: float, at: int) -> bool:
        """Whether it is secure after one more sample, kPa below ambient, at ``at`` µs."""
        self._high.take(kpa >= self._part.secure_kpa, at)
        self._low.take(kpa < self.least_kpa, at)
        if self._high.samples >= self._part.confirmed_samples:
            self.secure = True
        elif self._low.samples >= self._part.lost_samples:
            self.secure = False
        return self.secure

    def expire(self) -> None:
        """Without a fresh reading nothing is secure; it is again once it is seen above its lower limit."""
        self._high, self._low = Streak(), Streak()
