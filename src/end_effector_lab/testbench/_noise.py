"""Chance that depends on the seed and on what it is for, never on how often somebody asked."""

from __future__ import annotations

from functools import cache
from hashlib import blake2b
from random import Random

BLOCK = 1 << 12
_WORD = (1 << 64) - 1
_ODD, _MIXES = 0x9E3779B97F4A7C15, 0xD6E8FEB86659FD93


@cache
def _normal_numbers() -> tuple[float, ...]:
    """Standard normal numbers: a sensor's noise is one of them, so that no generator is made for each sample."""
    random = Random(BLOCK)
    return tuple([random.gauss(0.0, 1.0) for _ in range(BLOCK)])


@cache
def _most() -> float:
    return max(map(abs, _normal_numbers()))


class Noise:
    """Numbers that depend on the seed and on what they are for.

    Args:
        seed: any integer.
    """

    def __init__(self, seed: int) -> None:
        self._seed = seed
        self._normal = _normal_numbers()
        self.most = _most()
        """What no number of `normal` exceeds, above or below zero."""
        self._keys: dict[str, int] = {}

    def normal(self, what: str, at: int) -> float:
        """A standard normal number for ``what`` at ``at`` (µs)."""
        key = self._keys.get(what)
        if key is None:
            digest = blake2b(f"{self._seed} {what}".encode(), digest_size=8).digest()
            key = self._keys[what] = int.from_bytes(digest, "little")
        mixed = at * _ODD + key & _WORD
        mixed = (mixed ^ mixed >> 32) * _MIXES & _WORD
        return self._normal[(mixed ^ mixed >> 32) & BLOCK - 1]

    def between(self, what: str, low: int, high: int) -> int:
        """A whole number in ``low..high`` that belongs to ``what``."""
        return self.random(what).randint(low, high)

    def random(self, what: str) -> Random:
        """A generator of its own for ``what``."""
        return Random(f"{self._seed} {what}")
