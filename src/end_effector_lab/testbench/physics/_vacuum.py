"""A vacuum circuit with an ejector, a hose and a cup."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar, NamedTuple

from ._device import ACTUATOR, LEAKS, PRESSURE, STICKS, SolvedDevice
from ._parts import STEP_S, Course, Sensor, Valve


class Suction(NamedTuple):
    """The pressure over time, t in s.

    Attributes:
        level: the final pressure, the higher of the two equilibrium pressures.
        low: the lower equilibrium pressure.
        curve: coefficient of the equation, 1/(kPa s).
        start: the initial pressure, above ``low``.
    """

    level: float
    low: float
    curve: float
    start: float

    @classmethod
    def of(cls, curve: float, linear: float, constant: float, start: float) -> Suction:
        """Return the solution of ``dp/dt = -curve p² + linear p + constant``."""
        root = math.sqrt(linear * linear + 4 * curve * constant)
        return cls((linear + root) / (2 * curve), (linear - root) / (2 * curve), curve, start)

    def hurried(self, step_s: float) -> Suction:
        """Return a course as fast on average as Euler's method with this step."""
        return self._replace(curve=self.curve * (1 + step_s / 2 * self.curve * (self.start - self.low)))

    @property
    def rate(self) -> float:
        """Final rate of approach to the level, 1/s."""
        return self.curve * (self.level - self.low)

    def at(self, seconds: float) -> float:
        """Return the pressure ``seconds`` after the beginning."""
        left = self._share(self.start) * math.exp(-self.rate * seconds)
        return self.level + (self.level - self.low) * left / (1 - left)

    def reaches(self, value: float) -> float | None:
        """Return the seconds until the pressure crosses a value; None: it does not."""
        first, then = self._share(self.start), self._share(value)
        return math.log(first / then) / self.rate if then * first > 0 and abs(then) < abs(first) else None

    def lagged(self, rate: float, start: float) -> LaggedSuction:
        """Return the output of a first-order lag of this rate (1/s) that follows the suction from ``start`` on."""
        course = LaggedSuction(self, rate, 0.0)
        return course._replace(apart=start - course.at(0.0))

    def _share(self, pressure: float) -> float:
        return (pressure - self.level) / (pressure - self.low)


class LaggedSuction(NamedTuple):
    """The output of a first-order lag that follows a suction; ``apart``: its initial difference from the series below.

    There is no closed formula for it. The first terms of the series, by the derivatives of the pressure, are accurate
    to 0.1 kPa for a seal that is lost, and to 0.001 kPa for an ejector.
    """

    suction: Suction
    rate: float
    apart: float

    def at(self, seconds: float) -> float:
        """Return the value ``seconds`` after the beginning."""
        suction, lag = self.suction, 1 / self.rate
        here = suction.at(seconds)
        first = -suction.curve * (here - suction.level) * (here - suction.low)
        slope = -suction.curve * (2 * here - suction.level - suction.low)
        second = slope * first
        third = (slope * slope - 2 * suction.curve * first) * first
        fourth = (slope * slope - 8 * suction.curve * first) * slope * first
        series = lag * (first - lag * (second - lag * (third - lag * fourth)))
        return here - series + self.apart * math.exp(-self.rate * seconds)


ATMOSPHERE_KPA = 101.325
LEAK_AT_KPA = 60.0  # a leak's flow is stated at this vacuum
LOST_L_MIN = 200.0
VENT_L_MIN = 120.0  # fills it when off, at the same vacuum
VOLUME_L = 0.25  # hose and cup
BLOW_KPA = 40.0  # gauge, behind the throttle of a blow-off: what a cup that is closed comes to
BLOW_L_MIN = 400.0  # fills it, at the same vacuum
OFF_AT_KPA = 5.0  # a part that sticks comes off at this gauge pressure
_ULTIMATE_KPA = ATMOSPHERE_KPA - 85.0  # the deepest vacuum, absolute
_SUCTION = 67.0 / 60.0 / VOLUME_L / (ATMOSPHERE_KPA - _ULTIMATE_KPA)  # S0 / V, at atmosphere
_PER_L_MIN = ATMOSPHERE_KPA / LEAK_AT_KPA / 60.0 / VOLUME_L
_STILL_KPA = 1e-7
_GROWTH_S = 0.02
"""Interval in which a growing leak is taken as constant, s."""
PART_KPA, PART_HYSTERESIS_KPA, GONE_KPA = 55.0, 5.0, 10.0
"""Thresholds, kPa of vacuum: the part switch closes at the first and opens lower by the second; the gone switch closes
below the third.
"""


class VacuumCircuit(SolvedDevice):
    """Volume, ejector and leak: ``dp/dt = (Q p_atm - S(p) p) / V``, p absolute.

    ``S(p) = S0 (p - p_ult) / (p_atm - p_ult)``, ``Q = k (p_atm - p)``. It passes 55 kPa after 0.33 s and 75 kPa after
    0.95 s; with a leak of 4 l/min 55 kPa after 0.38 s and 75 kPa never; with 20 l/min it never reaches 55 kPa. When
    the valve closes, ambient air enters through the ejector. A blow-off adds compressed air: the part is gone sooner,
    and during the blow-off the pressure is above ambient. A part that sticks closes the circuit: its vacuum remains
    until it is blown off.

    Args:
        valve: switches the ejector.
    """

    traits: ClassVar = frozenset({ACTUATOR, PRESSURE, LEAKS, STICKS})
    valve_us: ClassVar = (20_000, 45_000)
    grips_bit: ClassVar = "part"
    released_bit: ClassVar = "gone"

    def __init__(self, valve: Valve | None = None, *, start: int = 0) -> None:
        super().__init__(valve or Valve(22_000), start)
        self._leak_l_min = self._leak_grows = self._first_leak = 0.0
        self._lost = self._sticks = self._stuck = False
        self._blow_off = Valve(self.valve.delay_us)
        self._absolute = ATMOSPHERE_KPA
        self._sensor = Sensor()
        self._switch = False
        self._course: Course | Suction = Course(ATMOSPHERE_KPA)
        self._lagged: Course | LaggedSuction = self._course

    @property
    def depth_kpa(self) -> float:
        """The real vacuum below ambient, kPa, without the lag of the sensor."""
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
        slow = abs(self._ahead(self._leak_l_min).at(STEP_S) - self._absolute) < _STILL_KPA
        grows = self.valve.is_open and self._leak_grows > 0
        valves = self.valve.settled and self._blow_off.settled
        return slow and not grows and valves and self._sensor.shows(self.depth_kpa)

    def command(self, active: bool, at: int) -> None:
        self._lost = False
        self._stuck = self._sticks if active else self._stuck
        super().command(active, at)

    def blow(self, active: bool, at: int) -> None:
        self._blow_off.command(active, at)
        self.stale = True

    def stick(self, sticks: bool) -> None:
        self._sticks, self._stuck, self.stale = sticks, sticks and self.valve.is_open, True

    def lose(self, at: int) -> None:
        """Take the part off the cup; the ejector stays on."""
        self._lost = self.stale = True

    def leak(self, litres_min: float, grows_l_min_s: float = 0.0) -> None:
        self._leak_l_min, self._leak_grows, self.stale = litres_min, grows_l_min_s, True

    def settle(self, active: bool) -> None:
        self.valve.settle(active)
        self._stuck, self.stale = active and self._sticks, True
        self._absolute = self._ahead(self._leak_l_min).level
        self._sensor.kpa = self.depth_kpa
        self._switch = self.depth_kpa >= PART_KPA

    def begin(self) -> None:
        self._blow_off.advance(self.now)
        self.valve.advance(self.now)
        self._stuck = self._stuck and self.depth_kpa > -OFF_AT_KPA
        super().begin()

    def switches_at(self) -> int | None:
        return min(
            [at for at in (self.valve.switches_at, self._blow_off.switches_at) if at is not None],
            default=None,
        )

    def solve(self) -> float | None:
        grows = self._leak_grows if self.valve.is_open else 0.0
        self._first_leak = self._leak_l_min
        self._course = self._ahead(self._leak_l_min + grows * _GROWTH_S / 2)
        self._lagged = self._course.lagged(1 / Sensor.LAG_S, ATMOSPHERE_KPA - self._sensor.kpa)
        comes_off = self._course.reaches(ATMOSPHERE_KPA + OFF_AT_KPA) if self._stuck else None
        return min([s for s in (comes_off, _GROWTH_S if grows else None) if s is not None], default=None)

    def show(self, seconds: float) -> None:
        self._absolute = self._course.at(seconds)
        self._sensor.kpa = ATMOSPHERE_KPA - self._lagged.at(seconds)
        if self._leak_grows and self.valve.is_open:
            self._leak_l_min = self._first_leak + self._leak_grows * seconds
        self._switch = self.depth_kpa >= PART_KPA - (PART_HYSTERESIS_KPA if self._switch else 0.0)

    def _ahead(self, leak_l_min: float) -> Course | Suction:
        """Return the absolute pressure from now on, with this leak.

        It is as fast as in steps of a millisecond, for which its figures were fitted to a real circuit.
        """
        leak = leak_l_min + (LOST_L_MIN if self._lost else 0.0)
        if not self.valve.is_open and not self._stuck:
            leak += VENT_L_MIN
        leaks = leak * _PER_L_MIN
        blows = BLOW_L_MIN * _PER_L_MIN if self._blow_off.is_open else 0.0
        comes_in = leaks * ATMOSPHERE_KPA + blows * (ATMOSPHERE_KPA + BLOW_KPA)
        if self.valve.is_open:
            linear = _SUCTION * _ULTIMATE_KPA - leaks - blows
            return Suction.of(_SUCTION, linear, comes_in, self._absolute).hurried(STEP_S)
        if not (rate := leaks + blows):
            return Course(self._absolute)
        return Course.towards(comes_in / rate, -math.log1p(-rate * STEP_S) / STEP_S, self._absolute)
