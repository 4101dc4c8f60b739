"""The compressed-air supply, at its sensor."""

from __future__ import annotations

import math

from ._grid import STEP_S, Model

_CLOSE_KPA = 1e-6


class Supply(Model):
    """A regulator that gives way a little under load.

    Args:
        regulated_kpa: gauge pressure without load.
        recovery_s: time constant.
    """

    def __init__(self, regulated_kpa: float = 600.0, *, recovery_s: float = 0.05, start: int = 0) -> None:
        super().__init__(start)
        self.regulated_kpa = regulated_kpa
        self.draw_kpa = 0.0
        self.kpa = regulated_kpa
        self._share = 1.0 - math.exp(-STEP_S / recovery_s)

    @property
    def settled(self) -> bool:
        return abs(self._target() - self.kpa) < _CLOSE_KPA

    def step(self) -> None:
        self.kpa += (self._target() - self.kpa) * self._share

    def _target(self) -> float:
        return max(self.regulated_kpa - self.draw_kpa, 0.0)
