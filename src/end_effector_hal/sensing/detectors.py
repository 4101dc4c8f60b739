"""Detectors of no single kind: frozen sensors, release of everything, supply, tool changer."""

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


class FrozenDetector:
    """Detects a value that is constant for too long: the noise of a working sensor changes its value.

    Args:
        after_us: time after which a constant value counts as frozen, µs.
        gap_us: time between two samples from which they are not consecutive, µs: the detector then starts again.
    """

    MEMORY: ClassVar = {"_value": int | None, "_since": int, "_last": int}

    def __init__(self, after_us: int, gap_us: int) -> None:
        self._after_us, self._gap_us = after_us, gap_us
        self._value: int | None = None
        self._since = self._last = 0

    def sample(self, value: int, at: int) -> bool:
        """Return whether the value is frozen, after one more sample at ``at`` µs."""
        if value != self._value or at - self._last >= self._gap_us:
            self._value, self._since = value, at
        self._last = at
        return at - self._since >= self._after_us


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
            value = readings.get(channel, at)
            if value is None or channel in readings.arrived:
                low.take(value is not None and below_ambient_kpa(value) < self._changer.vented_kpa, at)
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

    def sample(self, readings: Readings, at: int) -> bool:
        """Return whether a grip may start, after one more sample at ``at`` µs."""
        value = readings.get(self._supply.channel, at)
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
        said = self._shown(readings, at)
        if said is ToolEvidence.UNCLEAR:
            self._streaks = {level: Streak() for level in ToolEvidence}
            self.level = said
            return self.level
        if readings.arrived.isdisjoint(bits):
            return self.level
        for streak in self._streaks.values():
            if streak is not self._streaks[said]:
                streak.samples = 0
        self._streaks[said].take(True, at)
        if self._streaks[said].lasted(at, self._wait_us[said]):
            self.level = said
        return self.level

    def _shown(self, readings: Readings, at: int) -> ToolEvidence:
        """Return what this sample alone shows."""
        changer, carried = self._changer, readings.carried
        locked, unlocked = readings.get(changer.locked_bit, at), readings.get(changer.unlocked_bit, at)
        present = readings.get(changer.present_bit, at)
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
