"""Random numbers that depend on the seed and their purpose, never on how often a number was requested."""

from __future__ import annotations

from functools import cache
from hashlib import blake2b
from random import Random

BLOCK = 1 << 12
_WORD = (1 << 64) - 1
_ODD, _MIXES = 0x9E3779B97F4A7C15, 0xD6E8FEB86659FD93


@cache
def _normal_numbers() -> tuple[float, ...]:
    """Return standard normal numbers from which a sensor's noise is picked, so that no sample needs its own
    generator.
    """
    random = Random(BLOCK)
    return tuple([random.gauss(0.0, 1.0) for _ in range(BLOCK)])


@cache
def _most() -> float:
    return max(map(abs, _normal_numbers()))


class Noise:
    """Random numbers that depend on the seed and on their purpose.

    Args:
        seed: any integer.
    """

    def __init__(self, seed: int) -> None:
        self._seed = seed
        self._normal = _normal_numbers()
        self.most = _most()
        """Largest magnitude of the numbers that `normal` returns."""
        self._keys: dict[str, int] = {}

    def normal(self, what: str, at: int) -> float:
        """Return a standard normal number for ``what`` at ``at`` (µs)."""
        key = self._keys.get(what)
        if key is None:
            digest = blake2b(f"{self._seed} {what}".encode(), digest_size=8).digest()
            key = self._keys[what] = int.from_bytes(digest, "little")
        mixed = at * _ODD + key & _WORD
        mixed = (mixed ^ mixed >> 32) * _MIXES & _WORD
        return self._normal[(mixed ^ mixed >> 32) & BLOCK - 1]

    def between(self, what: str, low: int, high: int) -> int:
        """Return a whole number in ``low..high`` for ``what``."""
        return self.random(what).randint(low, high)

    def random(self, what: str) -> Random:
        """Return a separate random generator for ``what``."""
        return Random(f"{self._seed} {what}")
