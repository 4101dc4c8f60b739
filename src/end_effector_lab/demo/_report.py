"""What came out of one scenario: what was looked for in its recording, what was found, and when."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ._scenario import DemoScenario

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


@dataclass(frozen=True)
class Report:
    """A scenario with what its recording shows; ``folder`` holds the recording and its pictures."""

    scenario: DemoScenario
    verdict: str
    attempts: Mapping[str, int] = field(default_factory=dict)
    measures: tuple[Measure, ...] = ()
    findings: tuple[Finding, ...] = ()
    folder: Path | None = None
    seconds: float = 0.0

    @property
    def faults(self) -> tuple[str, ...]:
        """What is not as it should be, in words; empty: the scenario tells its story."""
        late = [
            f"{measure}: not within {LATEST_S * 1000:g} ms after it"
            for measure in self.measures
            if not measure.ok
        ]
        return (*(str(finding) for finding in self.findings if not finding.ok), *late)

    @property
    def ok(self) -> bool:
        """Whether the recording tells its story, in time."""
        return not self.faults

    def as_json(self) -> dict[str, Any]:
        """For ``--json``; times in seconds."""
        return {
            "scenario": self.scenario.name,
            "figure": self.scenario.figure or None,
            "outcome": self.verdict,
            "ok": self.ok,
            "attempts": dict(self.attempts),
            "measured": [
                {
                    "what": measure.what,
                    "expected_s": measure.expected_s,
                    "measured_s": round(measure.measured_s, 6),
                    "ok": measure.ok,
                }
                for measure in self.measures
            ],
            "faults": list(self.faults),
            "folder": str(self.folder) if self.folder else None,
            "seconds": round(self.seconds, 1),
        }
