"""Chance, from one seed: the same seed tells the same story."""

from __future__ import annotations

from random import Random


class Noise:
    """Numbers that depend on the seed and on what they are for, never on how often somebody asked.

    Args:
        seed: any integer.
    """

    def __init__(self, seed: int) -> None:
        self._seed = seed

    def normal(self, what: str, at: int) -> float:
        """A standard normal number for ``what`` at ``at`` (µs)."""
        return self.random(f"{what} {at}").gauss(0.0, 1.0)

    def between(self, what: str, low: int, high: int) -> int:
        """A whole number in ``low..high`` that belongs to ``what``."""
        return self.random(what).randint(low, high)

    def random(self, what: str) -> Random:
        """A generator of its own for ``what``."""
        return Random(f"{self._seed} {what}")
