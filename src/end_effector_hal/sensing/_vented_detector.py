"""Whether nothing is gripped any more, as IL-01 asks: stricter than what a release asks of one actuator."""

from __future__ import annotations

from typing import ClassVar

from end_effector_hal.codecs import Codec
from end_effector_hal.description import Description, VacuumActuator
from end_effector_hal.sensing._channels import channels_of
from end_effector_hal.signals import PART, Streak
from end_effector_hal.vocabulary import Evidence, to_us

from ._readings import Readings


class VentedDetector:
    """Every vacuum that is fitted is under 5 kPa for 0.5 s, and every cylinder is retracted."""

    MEMORY: ClassVar = {"_low": PART}

    def __init__(self, description: Description, codec: Codec) -> None:
        self._changer = description.tool_changer
        self._vacuums: list[VacuumActuator] = []
        self._others: list[int] = []
        for index, (_, part) in enumerate(description.ordered):
            if isinstance(part, VacuumActuator) and part.channel in codec.channels:
                self._vacuums.append(part)
            elif any(channel in codec.channels for channel in channels_of(part)):
                self._others.append(index)
        self._low = [Streak() for _ in self._vacuums]

    def sample(self, readings: Readings, evidence: list[Evidence], at: int) -> bool:
        """Whether it is so at ``at`` µs, with the evidence that goes with the same readings."""
        if self._changer is None:
            return False
        vented = all(evidence[index] is Evidence.GONE for index in self._others)
        for part, low in zip(self._vacuums, self._low, strict=True):
            value = readings.get(part.channel, at)
            if value is None or readings.arrived(part.channel):
                low.take(value is not None and self._is_low(value), at)
            vented = vented and low.lasted(at, to_us(self._changer.vented_s))
        return vented

    def _is_low(self, value: int | bool) -> bool:
        if isinstance(value, bool):
            return not value
        return self._changer is not None and -value / 1000 < self._changer.vented_kpa
