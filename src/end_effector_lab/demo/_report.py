"""The report on a scenario: what was expected and found in its recording, and when; and a table of reports."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from os.path import commonpath
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from end_effector_hal.vocabulary import display_name

from ._scenario import DemoScenario

LATEST_S = 0.1
"""Longest delay of a time-out or reset after its nominal time, s; it must not come earlier."""

WIDE = 110
"""Columns of a console with room for a measure on a line."""
_RESOLUTION_S = 1e-6
"""Time resolution of a recording, s: half of it is the error of two rounded times."""


@dataclass(frozen=True)
class Finding:
    """One fact of the story: its subject, the expected value, the value found."""

    what: str
    expected: str
    found: str
    ok: bool

    def __str__(self) -> str:
        """Return the fact as text, such as ``attempts: expected cylinder 2, found cylinder 3``."""
        return (
            f"{self.what}: {self.expected}"
            if self.ok
            else f"{self.what}: expected {self.expected}, found {self.found}"
        )


@dataclass(frozen=True)
class Measure:
    """A measured time and the time that the description gives, s."""

    what: str
    expected_s: float
    measured_s: float

    @property
    def late_s(self) -> float:
        """Delay after the nominal time; negative: too early."""
        return self.measured_s - self.expected_s

    @property
    def ok(self) -> bool:
        """Whether the time is not early and not later than `LATEST_S`."""
        return -_RESOLUTION_S < self.late_s < LATEST_S + _RESOLUTION_S

    def __str__(self) -> str:
        """Return the time as text, such as ``cylinder time-out 1: 5.004 s (expected 5 s)``."""
        return f"{self.what}: {self.measured_s:.3f} s (expected {self.expected_s:g} s)"


@dataclass(frozen=True)
class Report:
    """A scenario with the results of its recording; ``folder`` contains the recording and its figures."""

    scenario: DemoScenario
    verdict: str
    attempts: Mapping[str, int] = field(default_factory=dict)
    measures: tuple[Measure, ...] = ()
    findings: tuple[Finding, ...] = ()
    folder: Path | None = None
    seconds: float = 0.0

    @property
    def faults(self) -> tuple[str, ...]:
        """The deviations in words; empty if the scenario ran as expected."""
        late = [
            f"{measure}: not within {LATEST_S * 1000:g} ms after it"
            for measure in self.measures
            if not measure.ok
        ]
        return (*(str(finding) for finding in self.findings if not finding.ok), *late)

    @property
    def ok(self) -> bool:
        """Whether the scenario ran as expected, in time."""
        return not self.faults

    def as_json(self) -> dict[str, Any]:
        """Return the report for ``--json``; times in seconds."""
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


def print_table(console: Console, reports: Sequence[Report]) -> None:
    """Print scenario, outcome, attempts, measured and expected times; and the faults below the table."""
    table = Table(show_lines=True, expand=False)
    table.add_column("scenario", no_wrap=True)
    table.add_column("outcome")
    table.add_column("attempts")
    table.add_column("measured (expected) s", no_wrap=console.width >= WIDE)
    for report in reports:
        table.add_row(_name(report), report.verdict, _attempts(report), _times(report))
    console.print(table)
    for report in reports:
        for fault in report.faults:
            console.print(Text(f"NOT OK {report.scenario.name}: {fault}", style="red"), soft_wrap=True)
    folders = [report.folder for report in reports if report.folder is not None]
    if folders:
        parent = Path(commonpath([folder.parent for folder in folders]))
        names = ",".join(folder.name for folder in folders)
        each = f"{{{names}}}" if len(folders) > 1 else names
        console.print(f"recordings and pictures: {parent}/{each}/", soft_wrap=True, highlight=False)


def _name(report: Report) -> Text:
    """Return the name of the scenario, its figure in the paper and whether it ran as expected."""
    text = Text(report.scenario.name)
    if report.scenario.figure:
        text.append(f"\n{report.scenario.figure}", style="dim")
    return text.append_text(_ok(report.ok, before="\n"))


def _ok(ok: bool, *, before: str) -> Text:
    return Text(before).append("ok" if ok else "NOT OK", style="green" if ok else "bold red")


def _attempts(report: Report) -> Text:
    lines = [f"{display_name(name)} {number}" for name, number in report.attempts.items()]
    return Text("\n".join(lines) or "–")


def _times(report: Report) -> Text:
    text = Text()
    for index, measure in enumerate(report.measures):
        line = f"{display_name(measure.what)}  {measure.measured_s:.3f} ({measure.expected_s:g})"
        text.append("\n" * bool(index) + line).append_text(_ok(measure.ok, before=" "))
    return text if report.measures else Text("–")
