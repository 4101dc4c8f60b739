"""What came out of one scenario."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ._finding import LATEST_S, Finding, Measure
from ._scenario import DemoScenario


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
