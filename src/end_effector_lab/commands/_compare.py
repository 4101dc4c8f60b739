"""``eehal compare``: lists the differences of two recordings."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from end_effector_hal.cli import PathName, Progress, print_document
from end_effector_hal.errors import UsageError
from end_effector_hal.vocabulary import display_name

if TYPE_CHECKING:
    from end_effector_hal.recording import RunDifference, RunInfo, RunTables

_SOURCES = ("description", "hash", "version", "scenario", "seed", "ros_generation")


@click.command("compare", short_help="the differences of two recorded runs")
@click.argument("first", type=PathName())
@click.argument("second", type=PathName())
@click.option(
    "--within-s", default=0.1, show_default=True, type=click.FloatRange(0.0, 3600.0),
    help="Times that are nearer to each other are the same.",
)  # fmt: skip
@click.option(
    "--within-kpa", default=5.0, show_default=True, type=click.FloatRange(0.0, 10_000.0),
    help="Pressures that are nearer to each other are the same.",
)  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print {differences, sources} as JSON.")
def command(first: Path, second: Path, within_s: float, within_kpa: float, as_json: bool) -> None:
    """List the differences between two recordings: when, on which line, and what.

    FIRST and SECOND are folders of runs. In both, time is counted from the first command. Each state is searched in
    the other recording. The list contains states that come earlier or later there, measured from the state before, and
    intervals in which a pressure differs. Tool, scenario, seed and version of the runs are printed, but do not count
    as differences.

    Exit code 0: no difference; 1: there are some.
    """
    from end_effector_hal.recording import Tolerances, compare_runs

    with Progress("Comparing", shown=not as_json):
        runs = read_tables(first), read_tables(second)
        found = compare_runs(*runs, Tolerances(within_s, within_kpa))
        sources = _sources(runs[0].info, runs[1].info)
    if as_json:
        print_document({"differences": [each.as_json() for each in found], "sources": sources})
    else:
        _print(found, sources)
    raise click.exceptions.Exit(int(bool(found)))


def read_tables(folder: Path) -> RunTables:
    """Read the tables of a folder that `eehal run --record`, `eehal demo` or DataLogger wrote.

    Raises:
        UsageError: the folder has no table of states, the table has no row, or a table cannot be read.
    """
    from end_effector_hal.recording import RunTables

    states = states_in(folder)
    tables = RunTables.read(states)
    if not tables.log.rows:
        raise UsageError("This recording holds no row.", where=str(states))
    return tables


def states_in(path: Path) -> Path:
    """Return the table of states that a path names, or of its folder; raises UsageError if the folder has none."""
    states = path / "states.csv" if path.is_dir() else path
    if path.is_dir() and not states.exists():
        if any(path.glob("*.mcap")):
            raise UsageError(
                "There is no states.csv here, only traces.",
                where=str(path),
                todo="`eehal page`, `eehal report` and `eehal replay` show and judge traces.",
            )
        todo = (
            "Name a folder that `eehal run --record`, `eehal demo` or the launch file's log_directory wrote."
        )
        raise UsageError("This folder contains no recording.", where=str(path), todo=todo)
    return states


def _sources(first: RunInfo, second: RunInfo) -> dict[str, list[object]]:
    """Return the fields of run.json that differ, with both values by name."""
    both = {name: [getattr(first, name), getattr(second, name)] for name in _SOURCES}
    return {name: values for name, values in both.items() if values[0] != values[1]}


def _print(found: list[RunDifference], sources: dict[str, list[object]]) -> None:
    from end_effector_hal.recording import count_differences

    for name, (one, other) in sources.items():
        click.echo(f"{display_name(name)}: {_said(one)}, in the second {_said(other)}")
    rows = [
        (_seconds(each.first_s), _seconds(each.second_s), display_name(each.line), each.text)
        for each in found
    ]
    widths = [max((len(row[column]) for row in rows), default=0) for column in range(3)]
    for one_s, other_s, line, text in rows:
        click.echo(f"{one_s:>{widths[0]}}  {other_s:>{widths[1]}}  {line:{widths[2]}}  {text}")
    click.echo(f"{count_differences(len(found)).capitalize()}.")


def _said(value: object) -> str:
    return "not known" if value in (None, "") else str(value)


def _seconds(at: float | None) -> str:
    return "-" if at is None else f"{at:.3f} s"
