"""Detects a sensor that still sends but no longer measures: its value does not change by a single count."""

from __future__ import annotations

from typing import ClassVar


class FrozenDetector:
    """Detects a value that is constant for too long: the noise of a working sensor changes its value.

    Args:
        after_us: time after which a constant value counts as frozen, µs.
        gap_us: time between two samples from which they are not consecutive, µs: the detector then starts again.
    """

    MEMORY: ClassVar = {"_value": int | None, "_since": int, "_last": int}

    def __init__(self, after_us: int, gap_us: int) -> None:
        self._after_us, self._gap_us = after_us, gap_us
        self._value: int | None = None
        self._since = self._last = 0

    def sample(self, value: int, at: int) -> bool:
        """Return whether the value is frozen, after one more sample at ``at`` µs."""
        if value != self._value or at - self._last >= self._gap_us:
            self._value, self._since = value, at
        self._last = at
        return at - self._since >= self._after_us
