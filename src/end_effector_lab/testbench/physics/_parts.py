"""What the devices have in common: time on a grid of a millisecond, valve, sensor, air supply."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from copy import copy
from typing import Self

from ._course import Course

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


class SolvedModel(Model):
    """A model that is solved until something switches, so that it need not go there step by step.

    What switches, switches at a point of the grid. Between two of them the state depends on the time since the
    first alone, so that it is the same whatever the calls are.
    """

    def __init__(self, start: int = 0) -> None:
        super().__init__(start)
        self._begun = start
        self.due: int | None = None
        """µs on the grid at which something switches by itself; None: nothing does."""
        self.stale = True
        """Something has changed: `begin` is to be called before time goes on."""

    @abstractmethod
    def solve(self) -> float | None:
        """Solve it from the present state on; returns the seconds until something switches, None: nothing does."""

    @abstractmethod
    def show(self, seconds: float) -> None:
        """Have the state of so long after it was solved."""

    def switches_at(self) -> int | None:
        """µs at which something switches that is known by its time; None: nothing does."""
        return None

    def begin(self) -> None:
        """Solve it from now on."""
        self._begun, self.stale = self.now, False
        in_s, at = self.solve(), self.switches_at()
        dues = [] if in_s is None else [self._begun + math.ceil(in_s / STEP_S) * STEP_US]
        if at is not None:
            dues.append(self._begun - (self._begun - at) // STEP_US * STEP_US)
        self.due = max(min(dues), self._begun + STEP_US) if dues else None

    def go(self, to: int) -> None:
        """Have the state of ``to`` (µs), a point of the grid that is not after `due`."""
        self.now = to
        self.show((to - self._begun) / 1e6)
        if to == self.due:
            self.stale = True

    def ahead(self, to: int) -> Self:
        """Another one with the state of ``to`` (µs), which is before anything switches; this one stays as it is."""
        other = copy(self)
        vars(other).update(
            {name: copy(part) for name, part in vars(self).items() if isinstance(part, Sensor)}
        )
        other.go(to)
        return other

    def step(self) -> None:
        """A step is as long as any other time; ``now`` is moved by the caller."""
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
    """A mono-stable valve with a dead time; a pulse shorter than that does not switch it.

    Args:
        delay_us: from the coil to the air. Vacuum valves 20 to 45 ms, cylinder valves 15 to 60 ms.
    """

    def __init__(self, delay_us: int) -> None:
        self.delay_us = delay_us
        self.is_open = False
        self.switches_at: int | None = None
        """µs at which it does; None: no switching is under way."""

    @property
    def settled(self) -> bool:
        """No switching is under way."""
        return self.switches_at is None

    def command(self, opens: bool, at: int) -> None:
        """Switch the coil at ``at`` (µs)."""
        if opens == self.is_open:
            self.switches_at = None
        elif self.switches_at is None:
            self.switches_at = at + self.delay_us

    def advance(self, now: int) -> bool:
        """Whether it is open at ``now`` (µs)."""
        if self.switches_at is not None and now >= self.switches_at:
            self.is_open, self.switches_at = not self.is_open, None
        return self.is_open


CLOSE_KPA = 1e-6


class Sensor:
    """A first-order lag; ``kpa`` is what it shows."""

    LAG_S = 0.007
    """5 to 10 ms for the usual transmitter."""

    def __init__(self) -> None:
        self.kpa = 0.0

    def shows(self, kpa: float) -> bool:
        """Whether the lag is over."""
        return abs(kpa - self.kpa) < CLOSE_KPA


class Supply(SolvedModel):
    """A regulator that gives way a little under load.

    Args:
        regulated_kpa: gauge pressure without load.
    """

    LAG_S = 0.05

    def __init__(self, regulated_kpa: float = 600.0, *, start: int = 0) -> None:
        super().__init__(start)
        self._regulated_kpa = self.kpa = regulated_kpa
        self._draw_kpa = 0.0
        self._course = Course(regulated_kpa)

    @property
    def regulated_kpa(self) -> float:
        """Gauge pressure without load."""
        return self._regulated_kpa

    @regulated_kpa.setter
    def regulated_kpa(self, kpa: float) -> None:
        self._regulated_kpa, self.stale = kpa, True

    @property
    def draw_kpa(self) -> float:
        """How far all devices together pull it down."""
        return self._draw_kpa

    @draw_kpa.setter
    def draw_kpa(self, kpa: float) -> None:
        self._draw_kpa, self.stale = kpa, True

    @property
    def settled(self) -> bool:
        return abs(self._target() - self.kpa) < CLOSE_KPA

    @property
    def course(self) -> Course:
        """How it goes on from now."""
        return Course.towards(self._target(), 1 / self.LAG_S, self.kpa)

    def solve(self) -> None:
        self._course = self.course

    def show(self, seconds: float) -> None:
        self.kpa = self._course.at(seconds)

    def _target(self) -> float:
        return max(self._regulated_kpa - self._draw_kpa, 0.0)
