"""Time inside the core: integer microseconds on the monotonic clock."""

from __future__ import annotations


def to_us(seconds: float) -> int:
    """Seconds to whole microseconds."""
    return round(seconds * 1_000_000)


def to_s(us: int) -> float:
    """Microseconds to seconds."""
    return us / 1_000_000
