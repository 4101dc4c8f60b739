"""``eehal verify --sweep``: proves a grid over values of a description."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import asdict
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from end_effector_hal.cli import Progress, is_figure, print_document, write_whole
from end_effector_hal.errors import UsageError

from ._options import counted

if TYPE_CHECKING:
    from end_effector_lab.sweep import Axis, Proven

_MOST_ROWS = 60
_NONE_HOLDS = 4


def run(
    path: Path,
    wanted: Sequence[str],
    *,
    scheduler: str | None,
    jobs: int | None,
    output: Path | None,
    as_json: bool,
) -> int:
    """Prove each combination, print those that hold and write the results; return the exit code.

    Args:
        path: path of the description.
        wanted: axes as they were typed.
        scheduler, jobs: select the workers, see `open_workers`.
        output: the folder of the results; None: nothing is written.
        as_json: print JSON.
    """
    from end_effector_lab.results import new_results
    from end_effector_lab.sweep import combinations, read_axis, sweep
    from end_effector_lab.workers import open_workers

    axes = [read_axis(each) for each in wanted]
    combinations(axes)
    if output is not None and is_figure(output):
        raise UsageError("-o names the folder of a sweep, not a figure.", where=str(output))
    folder = None if output is None else new_results(output)
    with open_workers(scheduler, jobs) as workers, Progress("Reading", shown=not as_json) as progress:
        found = sweep(path, axes, workers, counted(progress, "combinations proven"))
    files = [] if folder is None else _write(axes, found, folder)
    if as_json:
        print_document(_document(axes, found) | {"files": [str(file) for file in files]})
    else:
        _print(axes, found, files)
    return 0 if any(each.holds for each in found) else _NONE_HOLDS


def _document(axes: Sequence[Axis], found: Sequence[Proven]) -> dict[str, Any]:
    return {
        "axes": {axis.key: list(axis.values) for axis in axes},
        "hold": sum(each.holds for each in found),
        "combinations": [asdict(each) for each in found],
    }


def _write(axes: Sequence[Axis], found: Sequence[Proven], folder: Path) -> list[Path]:
    from end_effector_hal.cli import json_text
    from end_effector_lab.sweep import DOCUMENT, TABLE, table

    rows = StringIO()
    csv.writer(rows, lineterminator="\n").writerows(table(axes, found))
    texts = {DOCUMENT: json_text(_document(axes, found)) + "\n", TABLE: rows.getvalue()}
    for name, text in texts.items():
        write_whole(folder / name, text.encode())
    return [folder / name for name in texts]


def _print(axes: Sequence[Axis], found: Sequence[Proven], files: Sequence[Path]) -> None:
    from end_effector_lab.sweep import table

    rows = table(axes, found)
    widths = [min(40, max(map(len, column))) for column in zip(*rows, strict=True)]
    for number, row in enumerate(rows[: _MOST_ROWS + 1]):
        text = "  ".join(value[:40].ljust(width) for value, width in zip(row, widths, strict=True)).rstrip()
        click.secho(text, bold=True) if number == 0 else click.echo(text)
    if len(found) > _MOST_ROWS:
        click.echo(f"and {len(found) - _MOST_ROWS} more, which -o FOLDER and --json list")
    seconds = sum(each.seconds for each in found)
    click.echo(
        f"\n{sum(each.holds for each in found)} of {len(found)} combinations hold; "
        f"{sum(each.states for each in found):,} states, {seconds:.1f} s of proof"
    )
    for file in files:
        click.echo(str(file))
