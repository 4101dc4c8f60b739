"""What the devices have in common: time in whole steps of a millisecond, valve, sensor, air supply."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod

STEP_US = 1000
STEP_S = STEP_US / 1e6


class Model(ABC):
    """Something physical that goes on in time, in fixed steps from its start.

    The steps lie on one grid whatever the calls are, so a model asked every 7 ms and one asked once a second
    tell the same story.

    Args:
        start: µs, the time of the initial state.
    """

    def __init__(self, start: int = 0) -> None:
        self.now = start

    @property
    @abstractmethod
    def settled(self) -> bool:
        """Whether a step would change nothing, so that any number of them can be left out."""

    @abstractmethod
    def step(self) -> None:
        """Go from ``now`` to one step later; ``now`` itself is moved by the caller."""

    def advance(self, at: int) -> None:
        """Go to the last grid point at or before ``at`` (µs); a time in the past changes nothing."""
        steps = (at - self.now) // STEP_US
        while steps > 0:
            if self.settled:
                self.now += steps * STEP_US
                return
            self.step()
            self.now += STEP_US
            steps -= 1


class Valve:
    """A mono-stable valve with a dead time; a pulse shorter than that does not switch it.

    Args:
        delay_us: from the coil to the air. Vacuum valves 20 to 45 ms, cylinder valves 15 to 60 ms.
    """

    def __init__(self, delay_us: int) -> None:
        self.delay_us = delay_us
        self.is_open = False
        self._switches_at: int | None = None

    @property
    def settled(self) -> bool:
        """No switching is under way."""
        return self._switches_at is None

    def command(self, opens: bool, at: int) -> None:
        """Switch the coil at ``at`` (µs)."""
        if opens == self.is_open:
            self._switches_at = None
        elif self._switches_at is None:
            self._switches_at = at + self.delay_us

    def advance(self, now: int) -> bool:
        """Whether it is open at ``now`` (µs)."""
        if self._switches_at is not None and now >= self._switches_at:
            self.is_open, self._switches_at = not self.is_open, None
        return self.is_open


_CLOSE_KPA = 1e-6


class Sensor:
    """A first-order lag; ``kpa`` is what it shows."""

    _share = 1.0 - math.exp(-STEP_S / 0.007)  # 5 to 10 ms for the usual transmitter

    def __init__(self) -> None:
        self.kpa = 0.0

    def follow(self, kpa: float) -> None:
        """One step towards the pressure that is there."""
        self.kpa += (kpa - self.kpa) * self._share

    def shows(self, kpa: float) -> bool:
        """Whether the lag is over."""
        return abs(kpa - self.kpa) < _CLOSE_KPA


class Supply(Model):
    """A regulator that gives way a little under load.

    Args:
        regulated_kpa: gauge pressure without load.
    """

    _share = 1.0 - math.exp(-STEP_S / 0.05)

    def __init__(self, regulated_kpa: float = 600.0, *, start: int = 0) -> None:
        super().__init__(start)
        self.regulated_kpa = regulated_kpa
        self.draw_kpa = 0.0
        self.kpa = regulated_kpa

    @property
    def settled(self) -> bool:
        return abs(self._target() - self.kpa) < _CLOSE_KPA

    def step(self) -> None:
        self.kpa += (self._target() - self.kpa) * self._share

    def _target(self) -> float:
        return max(self.regulated_kpa - self.draw_kpa, 0.0)
