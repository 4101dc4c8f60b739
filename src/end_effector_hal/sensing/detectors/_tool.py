"""From the two bits of a tool changer to what they prove (IL-04)."""

from __future__ import annotations

from typing import ClassVar

from end_effector_hal.description import ToolChanger
from end_effector_hal.sensing._readings import Readings
from end_effector_hal.signals import PART, Streak
from end_effector_hal.vocabulary import ToolEvidence, to_us


class ToolDetector:
    """Locked or unlocked once the bits say so for 100 ms; faulty when both or neither for 0.5 s; unclear when stale."""

    MEMORY: ClassVar = {"_streaks": PART, "level": ToolEvidence}

    def __init__(self, changer: ToolChanger) -> None:
        self._changer = changer
        self._streaks = {level: Streak() for level in ToolEvidence}
        self.level = ToolEvidence.UNCLEAR

    def sample(self, readings: Readings, at: int) -> ToolEvidence:
        """The evidence after one more sample at ``at`` µs."""
        locked = readings.get(self._changer.locked_bit, at)
        unlocked = readings.get(self._changer.unlocked_bit, at)
        if locked is None or unlocked is None:
            self._streaks = {level: Streak() for level in ToolEvidence}
            self.level = ToolEvidence.UNCLEAR
            return self.level
        if not (readings.arrived(self._changer.locked_bit) or readings.arrived(self._changer.unlocked_bit)):
            return self.level
        said = ToolEvidence.FAULTY
        if bool(locked) != bool(unlocked):
            said = ToolEvidence.LOCKED if locked else ToolEvidence.UNLOCKED
        for level, streak in self._streaks.items():
            streak.take(level is said, at)
        wait_s = self._changer.fault_s if said is ToolEvidence.FAULTY else self._changer.proven_s
        if self._streaks[said].lasted(at, to_us(wait_s)):
            self.level = said
        return self.level
