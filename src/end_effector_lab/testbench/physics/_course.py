"""The course of a quantity between two switchings: a level, and exponentials that fade towards it."""

from __future__ import annotations

import math
from typing import NamedTuple

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
