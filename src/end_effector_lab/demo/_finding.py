"""What was looked for in a recording, and what was found."""

from __future__ import annotations

from dataclasses import dataclass

LATEST_S = 0.1
"""A time-out or reset is taken at most this much after its nominal time, and never before it."""

_RESOLUTION_S = 1e-6
"""Of a recording: half of it is what two rounded times can be wrong by."""


@dataclass(frozen=True)
class Finding:
    """One fact that makes the story: what it is about, what was expected, what was found."""

    what: str
    expected: str
    found: str
    ok: bool

    def __str__(self) -> str:
        """``attempts: expected cylinder 2, found cylinder 3``."""
        return (
            f"{self.what}: {self.expected}"
            if self.ok
            else f"{self.what}: expected {self.expected}, found {self.found}"
        )


@dataclass(frozen=True)
class Measure:
    """A time that was measured, beside the one that the description gives; seconds."""

    what: str
    expected_s: float
    measured_s: float

    @property
    def late_s(self) -> float:
        """How much later than nominal; negative: too early."""
        return self.measured_s - self.expected_s

    @property
    def ok(self) -> bool:
        """Not early, and not later than `LATEST_S`."""
        return -_RESOLUTION_S < self.late_s < LATEST_S + _RESOLUTION_S

    def __str__(self) -> str:
        """``cylinder time-out 1: 5.004 s (expected 5 s)``."""
        return f"{self.what}: {self.measured_s:.3f} s (expected {self.expected_s:g} s)"
