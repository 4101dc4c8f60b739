"""What the devices have in common where it goes in steps of a millisecond: sensor, air supply."""

from __future__ import annotations

import math

from end_effector_lab.testbench.physics import _parts
from end_effector_lab.testbench.physics._parts import CLOSE_KPA, STEP_S, Model, Valve

__all__ = ["Sensor", "Supply", "Valve"]


class Sensor(_parts.Sensor):
    """One that follows the pressure step by step."""

    _share = 1.0 - math.exp(-STEP_S / _parts.Sensor.LAG_S)

    def follow(self, kpa: float) -> None:
        """One step towards the pressure that is there."""
        self.kpa += (kpa - self.kpa) * self._share


class Supply(Model):
    """A regulator that gives way a little under load.

    Args:
        regulated_kpa: gauge pressure without load.
    """

    _share = 1.0 - math.exp(-STEP_S / _parts.Supply.LAG_S)

    def __init__(self, regulated_kpa: float = 600.0, *, start: int = 0) -> None:
        super().__init__(start)
        self.regulated_kpa = regulated_kpa
        self.draw_kpa = 0.0
        self.kpa = regulated_kpa

    def regulate(self, kpa: float) -> None:
        self.regulated_kpa = kpa

    @property
    def settled(self) -> bool:
        return abs(self._target() - self.kpa) < CLOSE_KPA

    def step(self) -> None:
        self.kpa += (self._target() - self.kpa) * self._share

    def _target(self) -> float:
        return max(self.regulated_kpa - self.draw_kpa, 0.0)
