"""The pressure in a volume that is evacuated while air leaks in: ``dp/dt = -curve (p - level) (p - low)``."""

from __future__ import annotations

import math
from typing import NamedTuple


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
