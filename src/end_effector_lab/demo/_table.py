"""The table at the end of the demo."""

from __future__ import annotations

from collections.abc import Sequence
from os.path import commonpath
from pathlib import Path

from rich.console import Console
from rich.table import Table
from rich.text import Text

from end_effector_hal.vocabulary import display_name

from ._report import Report

WIDE = 110
"""A console this wide has room for each measure on a line of its own."""


def print_table(console: Console, reports: Sequence[Report]) -> None:
    """Scenario, outcome, attempts, times against those of the description; below it what is wrong."""
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
    """Of the scenario, with its figure in the paper and whether it ran as expected."""
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
