"""Pistons between two position switches: a cylinder with a spring return, and a tool changer."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar, Self

from ._device import ACTUATOR, CHANGER, PRESSURE, Device, SolvedDevice
from ._parts import CLOSE_KPA, STEP_S, Course, Sensor, Supply, Valve

RETRACT_S = 0.4
TRAVEL_KPA, RETURN_KPA = 270.0, 90.0
"""Plateau pressures, kPa: while it extends (set by load and friction), and while the spring pushes it back."""
FILL_S = 0.025
"""Time constant of the pressure, s."""
_MOVES_KPA, _RETURNS_KPA = 0.95 * TRAVEL_KPA, 1.1 * RETURN_KPA
"""The cylinder extends above the first and returns below the second pressure, kPa."""
_SWITCH = 0.02  # a position switch is made over the last 2 % of the stroke


class Cylinder(SolvedDevice):
    """A cylinder: valve delay, filling to a plateau, travel on it, rise to the supply pressure; the reverse on
    exhaust.

    Args:
        valve: fills the chamber when open, exhausts it when closed.
        supply: the air supply of the cylinder.
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
        self._extend_s = extend_s
        self._kpa = 0.0
        self._sensor = Sensor()
        self.position = self._first = 0.0  # 0 retracted, 1 extended
        self._speed = 0.0  # 1/s, outwards
        self._course = self._lagged = Course(0.0)

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
        return 10.0 if self.valve.is_open and (self._speed or 0.0 < self.position < 1.0) else 0.0

    @property
    def settled(self) -> bool:
        still = self.position == (1.0 if self.valve.is_open else 0.0)
        at_target = abs(self._target() - self._kpa) < CLOSE_KPA
        return still and at_target and self.valve.settled and self._sensor.shows(self._kpa)

    def settle(self, active: bool) -> None:
        self.valve.settle(active)
        self.stale, self._speed = True, 0.0
        self.position = 1.0 if active else 0.0
        self._kpa = self._sensor.kpa = self._target()

    def solve(self) -> float | None:
        self._course, changes = self._filling() if self.valve.is_open else self._emptying()
        self._lagged = self._course.lagged(1 / Sensor.LAG_S, self._sensor.kpa)
        self._first = self.position
        if self._speed > 0:
            changes.append((1.0 - self.position) * self._extend_s)
        elif self._speed < 0:
            changes.append(self.position * RETRACT_S)
        return min([each for each in changes if each is not None], default=None)

    def show(self, seconds: float) -> None:
        self._kpa, self._sensor.kpa = self._course.at(seconds), self._lagged.at(seconds)
        self.position = min(max(self._first + self._speed * seconds, 0.0), 1.0)

    def _filling(self) -> tuple[Course, list[float | None]]:
        """Return the pressure while the valve is open, and the times of the next changes."""
        supply, rate, changes = self._supply.course, 1 / FILL_S, list[float | None]()
        travels = self.position < 1.0
        if travels:
            changes.append(supply.reaches(TRAVEL_KPA))
        if travels and self._supply.kpa > TRAVEL_KPA:
            course = Course.towards(TRAVEL_KPA, rate, self._kpa)
        else:
            course = supply.lagged(rate, self._kpa)
        # it moves in the step in which it has the pressure for it
        self._speed = 1 / self._extend_s if travels and course.at(STEP_S) >= _MOVES_KPA else 0.0
        return course, [*changes, _a_step_before(course.reaches(_MOVES_KPA)) if travels else None]

    def _emptying(self) -> tuple[Course, list[float | None]]:
        """Return the pressure while the valve is closed, and the times of the next changes."""
        returns = self.position > 0.0
        course = Course.towards(self._target(), 1 / FILL_S, self._kpa)
        self._speed = -1 / RETRACT_S if returns and course.at(STEP_S) <= _RETURNS_KPA else 0.0
        return course, [_a_step_before(course.reaches(_RETURNS_KPA)) if returns else None]

    def _target(self) -> float:
        if self.valve.is_open:
            return min(TRAVEL_KPA, self._supply.kpa) if self.position < 1.0 else self._supply.kpa
        return RETURN_KPA if self.position > 0.0 else 0.0


def _a_step_before(seconds: float | None) -> float | None:
    """Return the time one step earlier; None if that is not in the future."""
    return seconds - STEP_S if seconds is not None and seconds > STEP_S else None


_LOCK_STEP = STEP_S / 0.15  # from one end to the other


class ToolChanger(Device):
    """A piston between two switches; in between, both are off.

    Args:
        valve: unlocks when open.
    """

    traits: ClassVar = frozenset({CHANGER})

    def __init__(self, valve: Valve | None = None, *, start: int = 0) -> None:
        super().__init__(valve or Valve(30_000), start)
        self.position = 0.0  # 0 locked, 1 unlocked

    @property
    def bits(self) -> Mapping[str, bool]:
        return {"locked": self.position <= _SWITCH, "unlocked": self.position >= 1 - _SWITCH}

    @property
    def settled(self) -> bool:
        return self.valve.settled and self.position == (1.0 if self.valve.is_open else 0.0)

    def settle(self, active: bool) -> None:
        self.valve.settle(active)
        self.position = 1.0 if active else 0.0

    def step(self) -> None:
        if self.valve.advance(self.now):
            self.position = min(self.position + _LOCK_STEP, 1.0)
        else:
            self.position = max(self.position - _LOCK_STEP, 0.0)
