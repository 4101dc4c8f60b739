"""Computes the evidence of a tool changer from its bits (IL-04, IL-05)."""

from __future__ import annotations

from typing import ClassVar

from end_effector_hal.description import ToolChanger
from end_effector_hal.sensing._readings import Readings
from end_effector_hal.signals import PART, Streak
from end_effector_hal.vocabulary import ToolEvidence, to_us


class ToolDetector:
    """Judges the tool changer from its bits.

    It is locked or unlocked once the bits show it for 100 ms, faulty when both bits are on or both off for 0.5 s, and
    unclear when a bit is stale. If a sensor shows whether a tool is present, LOCKED needs a present tool; without a
    tool the evidence is ABSENT.
    """

    MEMORY: ClassVar = {"_streaks": PART, "level": ToolEvidence}

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
        if not any(map(readings.arrived, bits)):
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
