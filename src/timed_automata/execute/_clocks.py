"""Clocks by the instants at which they were zero, and the windows of time in which constraints hold."""

from __future__ import annotations

from collections.abc import Iterable

from timed_automata.compiler import Bound

ALWAYS, NEVER = -(1 << 62), 1 << 62


class ClockInstants:
    """Clocks as instants: a clock of value ``c`` at time ``t`` was, or would have been, zero at ``t - c``."""

    def __init__(self, count: int, unit_us: int) -> None:
        self._zero = [0] * count
        self._unit = unit_us

    def start(self, at: int) -> None:
        """All are zero now."""
        self._zero = [at] * len(self._zero)

    @property
    def zeros(self) -> list[int]:
        """When each was zero, by its number."""
        return list(self._zero)

    def resume(self, zeros: list[int]) -> None:
        """Each was zero then."""
        self._zero = list(zeros)

    def set(self, resets: Iterable[tuple[int, int]], at: int) -> None:
        """Clocks get values, in the model's unit."""
        for clock, value in resets:
            self._zero[clock] = at - value * self._unit

    def window(self, bounds: Iterable[Bound]) -> tuple[int, int]:
        """The first and the last instant, in whole µs, at which a conjunction of constraints holds."""
        first, last = ALWAYS, NEVER
        for clock, op, value in bounds:
            instant = self._zero[clock] + value * self._unit
            if op in (">=", ">", "=="):
                first = max(first, instant + (op == ">"))
            if op in ("<=", "<", "=="):
                last = min(last, instant - (op == "<"))
        return first, last
