"""Judges from the supply pressure whether a new grip may start (IL-06)."""

from __future__ import annotations

from typing import ClassVar

from end_effector_hal.kinds.stanza import Supply
from end_effector_hal.sensing._readings import Readings


class SupplyDetector:
    """Judges whether the supply suffices for a new grip, with hysteresis; False without a fresh reading."""

    MEMORY: ClassVar = {"ok": bool, "low": bool, "kpa": float | None}

    def __init__(self, supply: Supply) -> None:
        self._supply = supply
        self.ok = True
        self.low = False
        self.kpa: float | None = None

    def sample(self, readings: Readings, at: int) -> bool:
        """Return whether a grip may start, after one more sample at ``at`` µs."""
        value = readings.get(self._supply.channel, at)
        if value is None:
            self.ok, self.kpa = False, None
            return self.ok
        if not readings.arrived(self._supply.channel):
            return self.ok
        if isinstance(value, bool):
            # no thresholds: the bit itself says whether there is air
            self.ok, self.low = value, not value
            return self.ok
        kpa, part = value / 1000, self._supply
        self.kpa = kpa
        self.ok = kpa >= part.refuse_kpa + (0.0 if self.ok else part.hysteresis_kpa)
        self.low = kpa < part.warn_kpa + (part.hysteresis_kpa if self.low else 0.0)
        return self.ok
