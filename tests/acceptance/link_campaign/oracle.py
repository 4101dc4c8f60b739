"""How it really is: the state of the simulated devices, remembered for as long as a reading may live."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable

from end_effector_hal.description import Description
from end_effector_hal.kinds.vacuum import VacuumActuator
from end_effector_lab.testbench import Bench

MARGIN_KPA = 1.5
"""Noise and lag of a sensor: so far may a truthful one be off."""
STANDSTILL_US = 100_000
"""It is looked five times as often: after so long without a look the machine had stood still."""


class Oracle:
    """Whether something was really so within the last moments."""

    def __init__(self, description: Description, bench: Bench, longest_us: int) -> None:
        self._description, self._bench, self._longest_us = description, bench, longest_us
        self._seen: deque[tuple[int, dict[str, tuple[bool, bool]]]] = deque()
        self._standstill = (0, 0)

    def look(self, at: int) -> None:
        """Remember how it is at ``at`` µs; the bench is there already."""
        if self._seen and at - self.newest > STANDSTILL_US:
            self._standstill = at, at - self.newest
        self._seen.append((at, {name: self._truth(name) for name in self._description.sequence}))
        while self._seen[0][0] < at - self._longest_us - self.stood_still_us(at, self._longest_us):
            self._seen.popleft()

    @property
    def newest(self) -> int:
        """µs of the last look."""
        return self._seen[-1][0] if self._seen else 0

    def stood_still_us(self, at: int, within_us: int) -> int:
        """How long nothing moved, up to at most ``within_us`` before ``at``; while it does now, until ``at``."""
        ended, lasted = self._standstill
        now = max(0, at - self.newest) if at - self.newest > STANDSTILL_US else 0
        return max(now, lasted if at - ended <= within_us else 0)

    def confirmed(self, names: Iterable[str], since: int) -> bool:
        """Whether each of them was really there at some time since then."""
        return all(any(seen[name][0] for at, seen in self._seen if at >= since) for name in names)

    def gone(self, names: Iterable[str], since: int) -> bool:
        """Whether each of them was really gone at some time since then."""
        return all(any(seen[name][1] for at, seen in self._seen if at >= since) for name in names)

    def _truth(self, name: str) -> tuple[bool, bool]:
        actuator, device = self._description.actuators[name], self._bench.devices[name]
        kpa = device.pressure_kpa or 0.0
        if isinstance(actuator, VacuumActuator):
            return -kpa >= actuator.lost_kpa - MARGIN_KPA, -kpa < actuator.gone_kpa + MARGIN_KPA
        supply = self._description.supply
        least = actuator.extended_fraction * supply.refuse_kpa - supply.hysteresis_kpa
        extended = device.bits["extended"]
        return extended or kpa >= least, not extended and kpa < actuator.retracted_kpa + 20 * MARGIN_KPA
