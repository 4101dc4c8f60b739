"""Computes the evidence of a cylinder from its pressure and its position bits."""

from __future__ import annotations

from typing import ClassVar

from end_effector_hal.kinds import ChannelReadings
from end_effector_hal.kinds.stanza import Supply
from end_effector_hal.signals import PART, Streak
from end_effector_hal.vocabulary import Evidence, to_us

from ._stanza import CylinderActuator


class CylinderDetector:
    """Judges a cylinder as extended (CONFIRMED), retracted (GONE), or between the two (PARTIAL).

    Extended: its position bit is on, or the pressure is at least 85 % of the supply pressure for 100 ms. Retracted:
    less than 50 kPa for 200 ms, and the extended bit is not on. If no pressure is carried, the retracted bit proves
    "retracted"; without that bit, an extended bit that is off proves it.
    """

    MEMORY: ClassVar = {"_held": bool, "_high": PART, "_low": PART, "level": Evidence}

    def __init__(self, actuator: CylinderActuator, supply: Supply) -> None:
        self._actuator, self._supply = actuator, supply
        self._held = False
        self._high, self._low = Streak(), Streak()
        self.level = Evidence.UNKNOWN

    def sample(self, readings: ChannelReadings, at: int) -> Evidence:
        """Return the evidence after one more sample at ``at`` µs."""
        part = self._actuator
        pressure = readings.get(part.channel, at)
        extended = readings.get(part.extended_bit, at)
        retracted = readings.get(part.retracted_bit, at)
        lacking = pressure is None and (
            part.channel in readings.carried or (extended is None and retracted is None)
        )
        if lacking and not extended:
            return self.expire()
        if pressure is not None and readings.arrived(part.channel):
            self._high.take(pressure >= self._threshold_pa(readings, at), at)
            self._low.take(pressure < part.retracted_kpa * 1000, at)
        if extended or self._high.lasted(at, to_us(part.extended_s)):
            self._held = True
            self.level = Evidence.CONFIRMED
        elif not (self._held and self._high.samples):
            # what was confirmed and still stands at its pressure is not lost: it is being confirmed again
            self._held = False
            gone = self._is_retracted(readings, pressure, extended, retracted, at)
            self.level = Evidence.GONE if gone else Evidence.PARTIAL
        return self.level

    def expire(self) -> Evidence:
        """Return UNKNOWN and restart the counts, because no fresh reading is available."""
        self._high, self._low = Streak(), Streak()
        self.level = Evidence.UNKNOWN
        return self.level

    def _is_retracted(
        self,
        readings: ChannelReadings,
        pressure: int | None,
        extended: int | None,
        retracted: int | None,
        at: int,
    ) -> bool:
        if pressure is not None:
            return self._low.lasted(at, to_us(self._actuator.retracted_s))
        if retracted is None and self._actuator.retracted_bit in readings.carried:
            return False  # it would say so, and does not
        return bool(retracted) if retracted is not None else not extended

    def _threshold_pa(self, readings: ChannelReadings, at: int) -> float:
        supply_pa = self._supply.pressure_pa(readings.get(self._supply.channel, at))
        # 85 % of no air at all is nothing: with less than a grip needs, the pressure of a rod at rest is no proof
        supply_pa = max(supply_pa, self._supply.refuse_kpa * 1000)
        # a little lower once extended: noise at the threshold is no loss
        margin_pa = self._supply.hysteresis_kpa * 1000 if self._held else 0.0
        return self._actuator.extended_fraction * supply_pa - margin_pa
