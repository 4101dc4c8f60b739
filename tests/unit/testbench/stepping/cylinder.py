"""A pneumatic cylinder with a spring return."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar, Self

from end_effector_lab.testbench.physics._cylinder import FILL_S, RETRACT_S, RETURN_KPA, TRAVEL_KPA
from end_effector_lab.testbench.physics._device import ACTUATOR, PRESSURE, Device
from end_effector_lab.testbench.physics._parts import CLOSE_KPA, STEP_S, Valve
from tests.unit.testbench.stepping.parts import Sensor, Supply

_SHARE = 1.0 - math.exp(-STEP_S / FILL_S)
_SWITCH = 0.02  # a position switch is made over the last 2 % of the stroke


class Cylinder(Device):
    """Valve delay, filling to a plateau, travel on it, rise to the supply pressure; the reverse on exhaust.

    Args:
        valve: fills the chamber when open, exhausts it when closed.
        supply: the air that it is fed with.
        extend_s: duration of the stroke (100 mm in 0.2 to 1 s).
    """

    traits: ClassVar = frozenset({ACTUATOR, PRESSURE})
    grips_bit: ClassVar = "extended"
    released_bit: ClassVar = "retracted"

    def __init__(
        self,
        valve: Valve | None = None,
        supply: Supply | None = None,
        *,
        extend_s: float = 0.4,
        start: int = 0,
    ) -> None:
        super().__init__(valve or Valve(30_000), start)
        self._supply = supply or Supply(start=start)
        self._extend = STEP_S / extend_s
        self._kpa = 0.0
        self._sensor = Sensor()
        self.position = 0.0  # 0 retracted, 1 extended

    @classmethod
    def on_air(cls, valve: Valve, supply: Supply, start: int) -> Self:
        return cls(valve, supply, start=start)

    @property
    def pressure_kpa(self) -> float:
        return self._sensor.kpa

    @property
    def bits(self) -> Mapping[str, bool]:
        return {"extended": self.position >= 1 - _SWITCH, "retracted": self.position <= _SWITCH}

    @property
    def draw_kpa(self) -> float:
        return 10.0 if self.valve.is_open and 0.0 < self.position < 1.0 else 0.0

    @property
    def settled(self) -> bool:
        still = self.position == (1.0 if self.valve.is_open else 0.0)
        at_target = abs(self._target() - self._kpa) < CLOSE_KPA
        return still and at_target and self.valve.settled and self._sensor.shows(self._kpa)

    def settle(self, active: bool) -> None:
        self.valve.is_open = active
        self.position = 1.0 if active else 0.0
        self._kpa = self._sensor.kpa = self._target()

    def step(self) -> None:
        opened = self.valve.advance(self.now)
        self._kpa += (self._target() - self._kpa) * _SHARE
        if opened and self._kpa >= 0.95 * TRAVEL_KPA:
            self.position = min(self.position + self._extend, 1.0)
        elif not opened and self._kpa <= 1.1 * RETURN_KPA:
            self.position = max(self.position - STEP_S / RETRACT_S, 0.0)
        self._sensor.follow(self._kpa)

    def _target(self) -> float:
        if self.valve.is_open:
            return min(TRAVEL_KPA, self._supply.kpa) if self.position < 1.0 else self._supply.kpa
        return RETURN_KPA if self.position > 0.0 else 0.0
