"""``eehal history``: what the recordings of a tool say about its grips, day by day."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING

import click

from end_effector_hal.errors import UsageError
from end_effector_hal.vocabulary import display_name

from ._options import PathName
from ._output import Progress, print_document, print_table
from .recorded import runs_in

if TYPE_CHECKING:
    from end_effector_hal.description import Description
    from end_effector_hal.page.recorded import ToolHistory

COLUMNS, HEIGHT = 60, 4
"""Largest size of a plot, characters."""
_BLOCKS = " ▁▂▃▄▅▆▇█"
MOST_NOTES = 20


@click.command("history")
@click.argument("description", metavar="DESCRIPTION", type=PathName())
@click.option(
    "--recordings", metavar="DIR", default="runs", show_default=True, type=PathName(),
    help="Folder with the recordings, at any depth.",
)  # fmt: skip
@click.option("--part", default="", metavar="NAME", help="Only the grips of this part.")
@click.option(
    "--json", "as_json", is_flag=True, help="Print {ok, tool, grips, days, recordings, notes} as JSON."
)
def command(description: Path, recordings: Path, part: str, as_json: bool) -> None:
    """Show how the grips of a tool change over time, so that wear is seen before a grip fails.

    Reads the recordings of the tool of DESCRIPTION (`eehal run --record`, `eehal serve --record`, `eehal record`, the
    nodes' log_directory): a table of the grips and their outcomes by day, and two plots for each actuator: the time
    from the activation to the confirmation, and the margin at the end of the hold. The margin is the distance of the
    pressure from the threshold that matters to the kind: of a vacuum, from that of a loss. A seal that wears takes
    longer and keeps less margin.

    First attempt: the share of the grips that succeeded with each actuator confirmed at once, of those that
    succeeded or were aborted. A recording that is damaged, or of another tool, is named and left out. Simulated
    runs count only if there are no others.

    Exit codes: 0 printed, 2 the description has a fault, or no recording has a grip of this tool.
    """
    from end_effector_hal.codecs import load_tool
    from end_effector_hal.page.recorded import read_history

    tool = load_tool(description)
    if part and part not in tool.parts:
        known = ", ".join(tool.parts) or "none"
        raise UsageError(f"The tool has no part {part!r}.", todo=f"Its parts: {known}.")
    with Progress("Reading", shown=not as_json) as progress:
        found = read_history(tool, runs_in(recordings) or (recordings,), part, progress)
    if not found.grips:
        reasons = " ".join(found.notes[:MOST_NOTES])
        raise UsageError(
            "No recording has a grip of this tool.",
            where=str(recordings),
            todo=reasons or "Record some: `eehal serve --record`, or name their folder: --recordings DIR.",
        )
    if as_json:
        print_document({
            "ok": True, "tool": tool.name, "grips": len(found.grips), "days": list(found.rows()),
            "recordings": found.recordings, "notes": found.notes,
        })  # fmt: skip
        return
    _print(tool, found)
    for note in found.notes[:MOST_NOTES]:
        click.echo(f"Note: {note}", err=True)
    if (more := len(found.notes) - MOST_NOTES) > 0:
        click.echo(f"Note: {more} more notes: --json.", err=True)


def _print(tool: Description, found: ToolHistory) -> None:
    from rich.table import Table

    first, last = (each.at.date().isoformat() for each in (found.grips[0], found.grips[-1]))
    recordings = "1 recording" if len(found.recordings) == 1 else f"{len(found.recordings)} recordings"
    grips = "1 grip" if len(found.grips) == 1 else f"{len(found.grips)} grips"
    click.echo(f"{tool.name}: {grips} in {recordings}, {first} to {last}")
    rows = list(found.rows())
    outcomes = list(dict.fromkeys(name for row in rows for name in row["outcomes"]))
    has_parts = any(row["part"] for row in rows)
    table = Table("day", *(["part"] if has_parts else []), box=None, pad_edge=False)
    for column in ("grips", *outcomes, "first attempt"):
        table.add_column(column, justify="right")
    for row in rows:
        rate = row["first_attempt_rate"]
        counts = (str(row["outcomes"].get(name, "")) for name in outcomes)
        named = [row["day"], row["part"]] if has_parts else [row["day"]]
        table.add_row(*named, str(row["grips"]), *counts, "-" if rate is None else f"{rate:.0%}")
    print_table(table)
    for name, actuator in tool.ordered:
        times = [grip.confirm_s[name] for grip in found.grips if name in grip.confirm_s]
        margins = [grip.margin_kpa[name] for grip in found.grips if name in grip.margin_kpa]
        label, most_s = display_name(name), f"{actuator.timeout_s:g}"
        _plot(f"{label}: time to confirm, s (time-out {most_s} s)", times, 2, max(times, default=0.0))
        _plot(f"{label}: margin at the end of the hold, kPa", margins, 1, min(margins, default=0.0))


def _plot(title: str, values: Sequence[float], decimals: int, worst: float) -> None:
    if not values:
        return
    each = -(-len(values) // COLUMNS)
    medians = [median(values[start : start + each]) for start in range(0, len(values), each)]
    top = max(*medians, 0.0, 10.0**-decimals)
    click.echo(f"\n{title}; one column: {'1 grip' if each == 1 else f'the median of {each} grips'}")
    scale = f"{top:.{decimals}f}"
    for row, line in enumerate(plotted(medians, top)):
        click.echo(f"{scale if row == 0 else '0' if row == HEIGHT - 1 else '':>{len(scale)}} │{line}")
    ends = f"first {medians[0]:.{decimals}f}, last {medians[-1]:.{decimals}f}"
    click.echo(f"{'':{len(scale)}}  {ends}, worst {worst:.{decimals}f}")


def plotted(values: Sequence[float], top: float, height: int = HEIGHT) -> list[str]:
    """Return the lines of a bar chart from the top down, one column for each value, from 0 to ``top``.

    The smallest bar is one eighth of a line; a value below 0 is an ``x``.
    """
    lines = []
    for line in reversed(range(height)):
        filled = (round(value / top * height * 8) - 8 * line for value in values)
        least = 1 if line == 0 else 0
        bars = (_BLOCKS[min(8, max(least, eighths))] for eighths in filled)
        below = "x" if line == 0 else " "
        lines.append("".join(below if value < 0 else bar for value, bar in zip(values, bars, strict=True)))
    return lines
