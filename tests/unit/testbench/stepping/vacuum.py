"""An ejector, a hose, a cup: first-order vacuum."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from end_effector_lab.testbench.physics._device import ACTUATOR, LEAKS, PRESSURE, STICKS, Device
from end_effector_lab.testbench.physics._parts import STEP_S, Valve
from end_effector_lab.testbench.physics._vacuum import (
    ATMOSPHERE_KPA,
    BLOW_KPA,
    BLOW_L_MIN,
    GONE_KPA,
    LEAK_AT_KPA,
    LOST_L_MIN,
    OFF_AT_KPA,
    PART_HYSTERESIS_KPA,
    PART_KPA,
    VENT_L_MIN,
    VOLUME_L,
)
from tests.unit.testbench.stepping.parts import Sensor

_SUCTION = 67.0 / 60.0 / VOLUME_L  # S0 / V, at atmosphere
_ULTIMATE_KPA = ATMOSPHERE_KPA - 85.0  # the deepest vacuum, absolute
_PER_L_MIN = ATMOSPHERE_KPA / LEAK_AT_KPA / 60.0 / VOLUME_L
_STILL_KPA = 1e-7


class VacuumCircuit(Device):
    """Volume, ejector and leak: ``dp/dt = (Q p_atm - S(p) p) / V``, p absolute.

    ``S(p) = S0 (p - p_ult) / (p_atm - p_ult)``, ``Q = k (p_atm - p)``. It passes 55 kPa
    after 0.33 s and 75 kPa after 0.95 s; with a leak of 4 l/min 55 kPa after 0.38 s and 75 kPa never; with
    20 l/min it never reaches 55 kPa. When the valve closes, ambient air comes in by the ejector. A blow-off brings
    compressed air in: gone is gone sooner, and while it blows the pressure is above ambient. A part that sticks
    closes the circuit: its vacuum stays until it is blown off.

    Args:
        valve: switches the ejector.
    """

    traits: ClassVar = frozenset({ACTUATOR, PRESSURE, LEAKS, STICKS})
    valve_us: ClassVar = (20_000, 45_000)
    grips_bit: ClassVar = "part"
    released_bit: ClassVar = "gone"

    def __init__(self, valve: Valve | None = None, *, start: int = 0) -> None:
        super().__init__(valve or Valve(22_000), start)
        self._leak_l_min = self._leak_grows = 0.0
        self._lost = self._sticks = self._stuck = False
        self._blow_off = Valve(self.valve.delay_us)
        self._absolute = ATMOSPHERE_KPA
        self._sensor = Sensor()
        self._switch = False

    @property
    def depth_kpa(self) -> float:
        """The vacuum itself, below ambient, without the sensor."""
        return ATMOSPHERE_KPA - self._absolute

    @property
    def pressure_kpa(self) -> float:
        return -self._sensor.kpa

    @property
    def bits(self) -> Mapping[str, bool]:
        return {"part": self._switch, "gone": self.depth_kpa < GONE_KPA}

    @property
    def draw_kpa(self) -> float:
        return 4.0 if self.valve.is_open else 0.0

    @property
    def settled(self) -> bool:
        slow = abs(self._slope(self._absolute)) * STEP_S < _STILL_KPA
        grows = self.valve.is_open and self._leak_grows > 0
        valves = self.valve.settled and self._blow_off.settled
        return slow and not grows and valves and self._sensor.shows(self.depth_kpa)

    def command(self, active: bool, at: int) -> None:
        self._lost = False
        self._stuck = self._sticks if active else self._stuck
        super().command(active, at)

    def blow(self, active: bool, at: int) -> None:
        self._blow_off.command(active, at)

    def stick(self, sticks: bool) -> None:
        self._sticks, self._stuck = sticks, sticks and self.valve.is_open

    def lose(self, at: int) -> None:
        """The part comes off the cup; the ejector goes on."""
        self._lost = True

    def leak(self, litres_min: float, grows_l_min_s: float = 0.0) -> None:
        self._leak_l_min, self._leak_grows = litres_min, grows_l_min_s

    def settle(self, active: bool) -> None:
        self.valve.is_open, self._stuck = active, active and self._sticks
        low, high = _ULTIMATE_KPA, ATMOSPHERE_KPA
        for _ in range(60):  # the slope falls with the pressure: bisect for its zero
            middle = (low + high) / 2
            low, high = (middle, high) if self._slope(middle) > 0 else (low, middle)
        self._absolute = high
        self._sensor.kpa = self.depth_kpa
        self._switch = self.depth_kpa >= PART_KPA

    def step(self) -> None:
        self.valve.advance(self.now)
        self._blow_off.advance(self.now)
        if self.valve.is_open:
            self._leak_l_min += self._leak_grows * STEP_S
        blown = self._blow_off.is_open or self._absolute > ATMOSPHERE_KPA
        highest = ATMOSPHERE_KPA + (BLOW_KPA if blown else 0.0)
        self._absolute = min(self._absolute + self._slope(self._absolute) * STEP_S, highest)
        self._stuck = self._stuck and self.depth_kpa > -OFF_AT_KPA
        self._sensor.follow(self.depth_kpa)
        self._switch = self.depth_kpa >= PART_KPA - (PART_HYSTERESIS_KPA if self._switch else 0.0)

    def _slope(self, absolute: float) -> float:
        """kPa/s."""
        leak = self._leak_l_min + (LOST_L_MIN if self._lost else 0.0)
        if not self.valve.is_open and not self._stuck:
            leak += VENT_L_MIN
        slope = leak * _PER_L_MIN * (ATMOSPHERE_KPA - absolute)
        if self._blow_off.is_open:
            slope += BLOW_L_MIN * _PER_L_MIN * (ATMOSPHERE_KPA + BLOW_KPA - absolute)
        if self.valve.is_open:
            slope -= _SUCTION * (absolute - _ULTIMATE_KPA) / (ATMOSPHERE_KPA - _ULTIMATE_KPA) * absolute
        return slope
