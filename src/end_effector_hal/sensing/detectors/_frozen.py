"""A sensor that still sends and no longer measures: its value does not move by a single count."""

from __future__ import annotations

from typing import ClassVar


class FrozenDetector:
    """The noise of a living sensor moves its value; one that stands still for long is frozen.

    Args:
        after_us: so long.
        gap_us: samples this far apart are not consecutive: the detector starts again.
    """

    MEMORY: ClassVar = {"_value": int | None, "_since": int, "_last": int}

    def __init__(self, after_us: int, gap_us: int) -> None:
        self._after_us, self._gap_us = after_us, gap_us
        self._value: int | None = None
        self._since = self._last = 0

    def sample(self, value: int, at: int) -> bool:
        """Whether it is frozen, after one more sample at ``at`` µs."""
        if value != self._value or at - self._last >= self._gap_us:
            self._value, self._since = value, at
        self._last = at
        return at - self._since >= self._after_us
