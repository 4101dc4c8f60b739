"""Random numbers that depend on the seed and their purpose, and frames with random disturbances."""

from __future__ import annotations

from functools import cache
from hashlib import blake2b
from random import Random

from end_effector_hal.codecs.described import CHECKSUMS

from ._scenario import LinkEffect

BLOCK = 1 << 12
LONGEST_BURST = 16
HIGHEST_UNIT = 247
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
    """Random numbers that depend on the seed and on their purpose, never on how often a number was requested.

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


def disturbed(data: bytes, effect: LinkEffect, random: Random, *, babble: bool = False) -> bytes:
    """Return ``data`` as it arrives; with ``babble``, the same number of random bytes."""
    if babble:
        return random.randbytes(len(data))
    if effect.bursts and random.random() < effect.bursts:
        data = _burst(data, random)
    if effect.noise:
        data = bytes(b ^ random.randint(1, 255) if random.random() < effect.noise else b for b in data)
    if effect.flips:
        data = bytes(b ^ _flips(effect.flips, random) for b in data)
    if effect.dropped:
        data = bytes(b for b in data if random.random() >= effect.dropped)
    if effect.doubled:
        data = b"".join(bytes([b]) * (1 + (random.random() < effect.doubled)) for b in data)
    return data


def of_another_unit(answer: bytes) -> bytes:
    """Return the answer that the next device on a Modbus line would send, with the right checksum."""
    body = bytes([answer[0] % HIGHEST_UNIT + 1]) + answer[1:-2]
    return body + CHECKSUMS["crc16-modbus"].of(body).to_bytes(2, "little")


def _burst(data: bytes, random: Random) -> bytes:
    length = random.randint(2, LONGEST_BURST)
    start = random.randrange(max(1, len(data) - length))
    return data[:start] + random.randbytes(len(data[start : start + length])) + data[start + length :]


def _flips(rate: float, random: Random) -> int:
    return sum(1 << bit for bit in range(8) if random.random() < rate)
