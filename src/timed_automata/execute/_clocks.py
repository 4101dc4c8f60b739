"""Clocks stored as the instants at which they were zero, and the time windows in which constraints hold."""

from __future__ import annotations

from collections.abc import Iterable

from timed_automata.compiler import Bound

ALWAYS, NEVER = -(1 << 62), 1 << 62


class ClockInstants:
    """Clocks stored as instants: a clock with value ``c`` at time ``t`` was, or would have been, zero at ``t - c``."""

    def __init__(self, count: int, unit_us: int) -> None:
        self._zero = [0] * count
        self._unit = unit_us

    def start(self, at: int) -> None:
        """Set all clocks to zero at ``at``."""
        self._zero = [at] * len(self._zero)

    @property
    def zeros(self) -> list[int]:
        """The instant at which each clock was zero, by clock number."""
        return list(self._zero)

    def resume(self, zeros: list[int]) -> None:
        """Restore the clocks from the instants at which they were zero."""
        self._zero = list(zeros)

    def set(self, resets: Iterable[tuple[int, int]], at: int) -> None:
        """Set clocks to values, given in the model's unit of time."""
        for clock, value in resets:
            self._zero[clock] = at - value * self._unit

    def window(self, bounds: Iterable[Bound]) -> tuple[int, int]:
        """Return the first and the last instant, in whole µs, at which a conjunction of constraints holds."""
        first, last = ALWAYS, NEVER
        for clock, op, value in bounds:
            instant = self._zero[clock] + value * self._unit
            if op in (">=", ">", "=="):
                first = max(first, instant + (op == ">"))
            if op in ("<=", "<", "=="):
                last = min(last, instant - (op == "<"))
        return first, last
