"""Time inside the core, as integer microseconds on the monotonic clock."""

from __future__ import annotations


def to_us(seconds: float) -> int:
    """Convert seconds to whole microseconds."""
    return round(seconds * 1_000_000)


def to_s(us: int) -> float:
    """Convert microseconds to seconds."""
    return us / 1_000_000
