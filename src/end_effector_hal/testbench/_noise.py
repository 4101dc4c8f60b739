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
        return self._random(f"{what} {at}").gauss(0.0, 1.0)

    def between(self, what: str, low: int, high: int) -> int:
        """A whole number in ``low..high`` that belongs to ``what``."""
        return self._random(what).randint(low, high)

    def corrupt(self, data: bytes, rate: float, at: int) -> bytes:
        """``data`` with each byte changed with probability ``rate``."""
        if rate <= 0.0:
            return data
        random = self._random(f"link {at}")
        return bytes(b ^ random.randint(1, 255) if random.random() < rate else b for b in data)

    def _random(self, what: str) -> Random:
        return Random(f"{self._seed} {what}")
