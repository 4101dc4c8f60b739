"""What becomes of bytes on a bad cable."""

from __future__ import annotations

from random import Random

from ._scenario import Scenario

LONGEST_BURST = 16


def disturbed(data: bytes, scenario: Scenario, random: Random, *, babble: bool = False) -> bytes:
    """``data`` as it arrives; ``babble``: as many random bytes instead of it."""
    if babble:
        return random.randbytes(len(data))
    if scenario.bursts and random.random() < scenario.bursts:
        data = _burst(data, random)
    if scenario.noise:
        data = bytes(b ^ random.randint(1, 255) if random.random() < scenario.noise else b for b in data)
    if scenario.flips:
        data = bytes(b ^ _flips(scenario.flips, random) for b in data)
    if scenario.dropped:
        data = bytes(b for b in data if random.random() >= scenario.dropped)
    if scenario.doubled:
        data = b"".join(bytes([b]) * (1 + (random.random() < scenario.doubled)) for b in data)
    return data


def _burst(data: bytes, random: Random) -> bytes:
    length = random.randint(2, LONGEST_BURST)
    start = random.randrange(max(1, len(data) - length))
    return data[:start] + random.randbytes(len(data[start : start + length])) + data[start + length :]


def _flips(rate: float, random: Random) -> int:
    return sum(1 << bit for bit in range(8) if random.random() < rate)
