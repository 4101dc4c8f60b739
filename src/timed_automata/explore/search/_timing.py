"""When the transitions of a symbolic run can happen: a system of differences, solved for the earliest times."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from fractions import Fraction

from timed_automata.compiler import Bound
from timed_automata.explore.zones import AT_MOST_ZERO, INFINITY, at_most, below

_MARGINS = tuple(Fraction(1, parts) for parts in (1, 2, 5, 10, 100, 1000))  # by which strict bounds are kept


@dataclass(slots=True)
class Timing:
    """Instants of a run, each not before the one before it; the first is 0, when all clocks are zero.

    A clock is an instant and what it was set to then: its value at another instant is the difference of the two.
    """

    _set: dict[int, tuple[int, int]] = field(default_factory=dict)
    _bounds: list[tuple[int, int, int]] = field(default_factory=list)  # (a, b, bound): a - b within bound
    now: int = 0

    def advance(self, *, delays: bool) -> None:
        """The next instant; the same time as the last one unless time may pass."""
        self.now += 1
        self._bounds.append((self.now - 1, self.now, AT_MOST_ZERO))
        if not delays:
            self._bounds.append((self.now, self.now - 1, AT_MOST_ZERO))

    def require(self, bounds: Iterable[Bound]) -> None:
        """Clock constraints that hold now."""
        for clock, op, value in bounds:
            if op in ("<", "<=", "=="):
                self.require_difference(clock, 0, below(value) if op == "<" else at_most(value))
            if op in (">", ">=", "=="):
                self.require_difference(0, clock, below(-value) if op == ">" else at_most(-value))

    def require_difference(self, left: int, right: int, bound: int) -> None:
        """A bound on the difference of two clocks now; 0 is the clock that is always zero."""
        if bound == INFINITY:
            return
        since_left, value_left = self._set.get(left, (0, 0)) if left else (self.now, 0)
        since_right, value_right = self._set.get(right, (0, 0)) if right else (self.now, 0)
        # (now - since_left + value_left) - (now - since_right + value_right)
        self._bounds.append((since_right, since_left, bound + 2 * (value_right - value_left)))

    def set(self, clock: int, value: int) -> None:
        """A clock gets a value now."""
        self._set[clock] = (self.now, value)

    def solve(self) -> list[Fraction]:
        """The earliest times of all instants, as round as they can be.

        Raises:
            AssertionError: there are none; the run is not one of the network.
        """
        for margin in (*_MARGINS, Fraction(1, self.now + 2)):
            times = self._earliest(margin)
            if times is not None:
                return times
        raise AssertionError("a symbolic run without times")

    def _earliest(self, margin: Fraction) -> list[Fraction] | None:
        bounds = [(a, b, (bound >> 1) - (0 if bound & 1 else margin)) for a, b, bound in self._bounds]
        times = [Fraction(0)] * (self.now + 1)
        for _ in range(self.now + 2):
            changed = False
            for a, b, most in bounds:
                if times[a] - times[b] > most:
                    times[b] = times[a] - most
                    changed = True
            if not changed:
                return times if times[0] == 0 else None
            if times[0] > 0:
                return None
        return None
