"""Common parts of the devices: time in steps of 1 ms, the course of a quantity, valve, sensor, air supply."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from copy import copy
from typing import NamedTuple, Self

_ALIKE = 1e-3
"""Smallest difference of two rates, 1/s, so that no amplitude becomes infinite."""
_HALVINGS = 50


class Course(NamedTuple):
    """``level + sum(amplitude * exp(-rate * t))``, t in s.

    Attributes:
        level: the final value.
        fading: amplitude and rate (1/s) of every exponential.
    """

    level: float
    fading: tuple[tuple[float, float], ...] = ()

    @classmethod
    def towards(cls, level: float, rate: float, start: float) -> Course:
        """Return the course from ``start`` to ``level`` with this rate (1/s)."""
        return cls(level, ((start - level, rate),))

    def at(self, seconds: float) -> float:
        """Return the value ``seconds`` after the beginning."""
        value = self.level
        for amplitude, rate in self.fading:
            value += amplitude * math.exp(-rate * seconds)
        return value

    def after(self, seconds: float) -> Course:
        """Return the same course with a beginning ``seconds`` later."""
        return Course(self.level, tuple([(a * math.exp(-rate * seconds), rate) for a, rate in self.fading]))

    def lagged(self, rate: float, start: float) -> Course:
        """Return the output of a first-order lag of this rate (1/s) that follows the course from ``start`` on."""
        fading, rest = [], start - self.level
        for amplitude, its in self.fading:
            apart = rate - its if abs(rate - its) > _ALIKE else _ALIKE
            lags = amplitude * rate / apart
            fading.append((lags, its))
            rest -= lags
        return Course(self.level, (*fading, (rest, rate)))

    def reaches(self, value: float) -> float | None:
        """Return the seconds until a monotonic course crosses a value; None: it does not."""
        begins = self.at(0.0) - value
        if not self.fading or begins == 0.0 or (begins > 0) == (self.level - value >= 0):
            return None
        low, high = 0.0, 1.0 / min(rate for _, rate in self.fading)
        while (self.at(high) - value > 0) == (begins > 0):
            high *= 2
            if high > 1e6:
                return None
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            low, high = (middle, high) if (self.at(middle) - value > 0) == (begins > 0) else (low, middle)
        return high


STEP_US = 1000
STEP_S = STEP_US / 1e6


class Model(ABC):
    """A physical model that advances in fixed steps from its start.

    The steps lie on one grid, independent of the times of the calls, so a model that is sampled every 7 ms and one
    that is sampled once a second have the same course.

    Args:
        start: time of the initial state, µs.
    """

    def __init__(self, start: int = 0) -> None:
        self.now = start

    @property
    @abstractmethod
    def settled(self) -> bool:
        """Whether a step would change nothing, so that any number of steps can be skipped."""

    @abstractmethod
    def step(self) -> None:
        """Advance the state by one step from ``now``; the caller changes ``now``."""

    def advance(self, at: int) -> None:
        """Advance to the last grid point at or before ``at`` (µs); a time in the past changes nothing."""
        steps = (at - self.now) // STEP_US
        while steps > 0:
            if self.settled:
                self.now += steps * STEP_US
                return
            self.step()
            self.now += STEP_US
            steps -= 1


class SolvedModel(Model):
    """A model that is computed in closed form until the next switching, without steps.

    All switchings happen at grid points. Between two of them the state depends only on the time since the first, so
    that it is independent of the times of the calls.
    """

    def __init__(self, start: int = 0) -> None:
        super().__init__(start)
        self._begun = start
        self.due: int | None = None
        """Grid time of the next switching by itself, µs; None: there is none."""
        self.stale = True
        """Whether the state has changed, so that `begin` must be called before time advances."""

    @abstractmethod
    def solve(self) -> float | None:
        """Compute the course from the present state on; return the seconds until something switches, None: nothing
        does.
        """

    @abstractmethod
    def show(self, seconds: float) -> None:
        """Set the state ``seconds`` after the last `solve`."""

    def switches_at(self) -> int | None:
        """Return the known time of the next switching, µs; None: there is none."""
        return None

    def begin(self) -> None:
        """Compute the course from now on."""
        self._begun, self.stale = self.now, False
        in_s, at = self.solve(), self.switches_at()
        dues = [] if in_s is None else [self._begun + math.ceil(in_s / STEP_S) * STEP_US]
        if at is not None:
            dues.append(self._begun - (self._begun - at) // STEP_US * STEP_US)
        self.due = max(min(dues), self._begun + STEP_US) if dues else None

    def go(self, to: int) -> None:
        """Set the state of ``to`` (µs), a grid point not after `due`."""
        self.now = to
        self.show((to - self._begun) / 1e6)
        if to == self.due:
            self.stale = True

    def ahead(self, to: int) -> Self:
        """Return a copy in the state of ``to`` (µs), which must be before any switching; this model is unchanged."""
        other = copy(self)
        vars(other).update(
            {name: copy(part) for name, part in vars(self).items() if isinstance(part, Sensor)}
        )
        other.go(to)
        return other

    def step(self) -> None:
        """Advance the state by one step; the caller changes ``now``."""
        if self.stale:
            self.begin()
        self.go(self.now + STEP_US)
        self.now -= STEP_US

    def advance(self, at: int) -> None:
        at = self.now + (at - self.now) // STEP_US * STEP_US
        while self.now < at:
            if self.stale:
                self.begin()
            self.go(at if self.due is None else min(at, self.due))


class Valve:
    """A mono-stable valve with a dead time; a shorter pulse does not switch it.

    Args:
        delay_us: time from the coil to the air, µs. Vacuum valves 20 to 45 ms, cylinder valves 15 to 60 ms.
    """

    def __init__(self, delay_us: int) -> None:
        self.delay_us = delay_us
        self.is_open = False
        self.switches_at: int | None = None
        """Time of the pending switching, µs; None: none is pending."""

    @property
    def settled(self) -> bool:
        """True if no switching is pending."""
        return self.switches_at is None

    def command(self, opens: bool, at: int) -> None:
        """Switch the coil at ``at`` (µs)."""
        if opens == self.is_open:
            self.switches_at = None
        elif self.switches_at is None:
            self.switches_at = at + self.delay_us

    def settle(self, opens: bool) -> None:
        """Set the state after a long time: open or closed, with no switching pending."""
        self.is_open, self.switches_at = opens, None

    def advance(self, now: int) -> bool:
        """Switch if it is due, and return whether the valve is open at ``now`` (µs)."""
        if self.switches_at is not None and now >= self.switches_at:
            self.is_open, self.switches_at = not self.is_open, None
        return self.is_open


CLOSE_KPA = 1e-6


class Sensor:
    """A pressure sensor with a first-order lag; ``kpa`` is its reading."""

    LAG_S = 0.007
    """Time constant, s; 5 to 10 ms for a usual transmitter."""

    def __init__(self) -> None:
        self.kpa = 0.0

    def shows(self, kpa: float) -> bool:
        """Return whether the reading has reached the pressure."""
        return abs(kpa - self.kpa) < CLOSE_KPA


class Supply(SolvedModel):
    """A regulator whose pressure drops a little under load.

    Args:
        regulated_kpa: gauge pressure without load.
    """

    LAG_S = 0.05

    def __init__(self, regulated_kpa: float = 600.0, *, start: int = 0) -> None:
        super().__init__(start)
        self._regulated_kpa = self.kpa = regulated_kpa
        self.draw_kpa = 0.0
        """Pressure drop due to all devices together, kPa; see `load`."""
        self._course = Course(regulated_kpa)

    def regulate(self, kpa: float) -> None:
        """Set the gauge pressure without load, kPa."""
        self._regulated_kpa, self.stale = kpa, True

    def load(self, draw_kpa: float) -> None:
        """Set the pressure drop due to all devices together, kPa."""
        self.draw_kpa, self.stale = draw_kpa, True

    @property
    def settled(self) -> bool:
        return abs(self._target() - self.kpa) < CLOSE_KPA

    @property
    def course(self) -> Course:
        """The course of the pressure from now on."""
        return Course.towards(self._target(), 1 / self.LAG_S, self.kpa)

    def solve(self) -> None:
        self._course = self.course

    def show(self, seconds: float) -> None:
        self.kpa = self._course.at(seconds)

    def _target(self) -> float:
        return max(self._regulated_kpa - self.draw_kpa, 0.0)
