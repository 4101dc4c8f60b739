"""A pressure transmitter: what it measures, a little later."""

from __future__ import annotations

import math

from ._grid import STEP_S

_CLOSE_KPA = 1e-6


class Sensor:
    """A first-order lag.

    Args:
        lag_s: time constant, 5 to 10 ms for the usual transmitter.
        kpa: what it shows at first.
    """

    def __init__(self, lag_s: float = 0.007, kpa: float = 0.0) -> None:
        self.kpa = kpa
        self._share = 1.0 - math.exp(-STEP_S / lag_s)

    def follow(self, kpa: float) -> None:
        """One step towards the pressure that is there."""
        self.kpa += (kpa - self.kpa) * self._share

    def shows(self, kpa: float) -> bool:
        """Whether the lag is over."""
        return abs(kpa - self.kpa) < _CLOSE_KPA
