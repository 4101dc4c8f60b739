"""Detectors of no single kind: release of everything, supply, tool changer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from end_effector_hal.codecs import Carrier
from end_effector_hal.description import Description, ToolChanger
from end_effector_hal.kinds import below_ambient_kpa, kind_of
from end_effector_hal.kinds.stanza import Supply
from end_effector_hal.sensing._readings import Readings
from end_effector_hal.signals import NESTED, Streak
from end_effector_hal.vocabulary import Evidence, ToolEvidence, to_us


class ReleaseDetector:
    """Detects that all actuators with sensors are released.

    An actuator must be GONE; a vacuum with a pressure sensor must instead be below 5 kPa for 0.5 s (the tool changer's
    defaults).
    """

    MEMORY: ClassVar = {"_low": NESTED}

    def __init__(self, description: Description, carrier: Carrier) -> None:
        self._changer = description.tool_changer
        self._vented_us = to_us(self._changer.vented_s) if self._changer else 0
        self._below_ambient: list[str] = []
        self._others: list[int] = []
        for index, (_, actuator) in enumerate(description.ordered):
            kind = kind_of(actuator)
            if kind.below_ambient and actuator.channel in carrier.channels:
                self._below_ambient.append(actuator.channel)
            elif any(channel in carrier.channels for channel in kind.channel_names(actuator)):
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
            value = readings.fresh.get(channel)
            if value is None:
                low.samples = 0
            elif channel in readings.arrived:
                kpa = -value / 1000 if type(value) is int else below_ambient_kpa(value)
                if kpa < self._changer.vented_kpa:
                    low.take(True, at)
                else:
                    low.samples = 0
            released = released and low.lasted(at, self._vented_us)
        return released


class SupplyDetector:
    """Judges whether the supply suffices for a new grip, with hysteresis; False without a fresh reading."""

    MEMORY: ClassVar = {"ok": bool, "low": bool, "kpa": float | None}

    def __init__(self, supply: Supply) -> None:
        self._supply = supply
        self.ok = True
        self.low = False
        self.kpa: float | None = None

    def sample(self, readings: Readings) -> bool:
        """Return whether a grip may start, after one more sample."""
        value = readings.fresh.get(self._supply.channel)
        if value is None:
            self.ok, self.kpa = False, None
            return self.ok
        if self._supply.channel not in readings.arrived:
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


class ToolDetector:
    """Judges the tool changer from its bits.

    It is locked or unlocked once the bits show it for 100 ms, faulty when both bits are on or both off for 0.5 s, and
    unclear when a bit is stale. If a sensor shows whether a tool is present, LOCKED needs a present tool; without a
    tool the evidence is ABSENT.
    """

    MEMORY: ClassVar = {"_streaks": NESTED, "level": ToolEvidence}

    def __init__(self, changer: ToolChanger) -> None:
        self._changer = changer
        self._wait_us = dict.fromkeys(ToolEvidence, to_us(changer.proven_s))
        self._wait_us[ToolEvidence.FAULTY] = to_us(changer.fault_s)
        self._streaks = {level: Streak() for level in ToolEvidence}
        self.level = ToolEvidence.UNCLEAR

    def sample(self, readings: Readings, at: int) -> ToolEvidence:
        """Return the evidence after one more sample at ``at`` µs."""
        changer = self._changer
        bits = (changer.locked_bit, changer.unlocked_bit, changer.present_bit)
        said = self._shown(readings)
        if said is ToolEvidence.UNCLEAR:
            self._streaks = {level: Streak() for level in ToolEvidence}
            self.level = said
            return self.level
        if readings.arrived.isdisjoint(bits):
            return self.level
        shown = self._streaks[said]
        for streak in self._streaks.values():
            if streak is not shown:
                streak.samples = 0
        shown.take(True, at)
        if self.level is not said and shown.lasted(at, self._wait_us[said]):
            self.level = said
        return self.level

    def _shown(self, readings: Readings) -> ToolEvidence:
        """Return what this sample alone shows."""
        changer, carried, read = self._changer, readings.carried, readings.fresh.get
        locked, unlocked, present = (
            read(changer.locked_bit),
            read(changer.unlocked_bit),
            read(changer.present_bit),
        )
        absent = present is not None and not present
        if changer.locked_bit not in carried and changer.unlocked_bit not in carried:
            return ToolEvidence.ABSENT if absent else ToolEvidence.UNCLEAR  # more cannot be shown
        if locked is None or unlocked is None or (present is None and changer.present_bit in carried):
            return ToolEvidence.UNCLEAR
        if bool(locked) == bool(unlocked):
            return ToolEvidence.FAULTY
        if unlocked:
            return ToolEvidence.UNLOCKED
        return ToolEvidence.ABSENT if absent else ToolEvidence.LOCKED
