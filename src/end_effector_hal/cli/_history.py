"""``eehal history``: what the recordings of a tool say about its grips, day by day."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from end_effector_hal.errors import UsageError

from ._options import PathName
from ._output import Progress, print_document, print_table
from .recorded import runs_in

if TYPE_CHECKING:
    from end_effector_hal.page.recorded import ToolHistory

HEIGHT = 4
"""Height of a plot, lines."""
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
    "--json",
    "as_json",
    is_flag=True,
    help="Print {ok, tool, grips, said, days, trends, recordings, notes} as JSON.",
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
    from end_effector_hal.page.recorded import NO_GRIP, read_history

    tool = load_tool(description)
    if part and part not in tool.parts:
        known = ", ".join(tool.parts) or "none"
        raise UsageError(f"The tool has no part {part!r}.", todo=f"Its parts: {known}.")
    with Progress("Reading", shown=not as_json) as progress:
        found = read_history(tool, runs_in(recordings) or (recordings,), part, progress)
    if not found.grips:
        reasons = " ".join(found.notes[:MOST_NOTES])
        raise UsageError(
            NO_GRIP,
            where=str(recordings),
            todo=reasons or "Record some: `eehal serve --record`, or name their folder: --recordings DIR.",
        )
    if as_json:
        print_document({"ok": True, **found.as_json()})
        return
    _print(found)
    for note in found.notes[:MOST_NOTES]:
        click.echo(f"Note: {note}", err=True)
    if (more := len(found.notes) - MOST_NOTES) > 0:
        click.echo(f"Note: {more} more notes: --json.", err=True)


def _print(found: ToolHistory) -> None:
    from rich.table import Table

    click.echo(found.said)
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
    for trend in found.trends():
        click.echo(f"\n{trend.title}; {trend.column}")
        width = len(trend.top_label)
        labels = [trend.top_label, *[""] * (HEIGHT - 2), "0"]
        for label, line in zip(labels, plotted(trend.values, trend.top), strict=True):
            click.echo(f"{label:>{width}} │{line}")
        click.echo(f"{'':{width}}  {trend.ends}")


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
