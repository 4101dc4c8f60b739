"""Detects that nothing is gripped any more (IL-01), which is stricter than one actuator's release."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from end_effector_hal.codecs import Carrier
from end_effector_hal.description import Description
from end_effector_hal.kinds import below_ambient_kpa, kind_of
from end_effector_hal.sensing._readings import Readings
from end_effector_hal.signals import PART, Streak
from end_effector_hal.vocabulary import Evidence, to_us


class ReleaseDetector:
    """Detects that all actuators with sensors are released.

    An actuator must be GONE; a vacuum with a pressure sensor must instead be below 5 kPa for 0.5 s (the tool changer's
    defaults).
    """

    MEMORY: ClassVar = {"_low": PART}

    def __init__(self, description: Description, carrier: Carrier) -> None:
        self._changer = description.tool_changer
        self._vented_us = to_us(self._changer.vented_s) if self._changer else 0
        self._below_ambient: list[str] = []
        self._others: list[int] = []
        for index, (_, part) in enumerate(description.ordered):
            kind = kind_of(part)
            if kind.below_ambient and part.channel in carrier.channels:
                self._below_ambient.append(part.channel)
            elif any(channel in carrier.channels for channel in kind.channel_names(part)):
                self._others.append(index)
        self._low = [Streak() for _ in self._below_ambient]

    def sample(self, readings: Readings, evidence: Sequence[Evidence], at: int) -> bool:
        """Return whether everything is released at ``at`` µs; ``evidence`` belongs to the same readings."""
        if self._changer is None:
            return False
        released = True
        for index in self._others:
            released = released and evidence[index] is Evidence.GONE
        for channel, low in zip(self._below_ambient, self._low, strict=True):
            value = readings.get(channel, at)
            if value is None or readings.arrived(channel):
                low.take(value is not None and below_ambient_kpa(value) < self._changer.vented_kpa, at)
            released = released and low.lasted(at, self._vented_us)
        return released
