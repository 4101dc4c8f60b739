"""``eehal matrix``: plays every fault at every moment, with every command."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from end_effector_hal.cli import PathName, Progress, json_text, print_document, write_whole
from end_effector_hal.errors import UsageError
from end_effector_hal.vocabulary import printable

from ._options import counted, playing_options

if TYPE_CHECKING:
    from end_effector_hal.description import Description
    from end_effector_lab.trials import Cell, Played
    from end_effector_lab.workers import Workers


@click.command("matrix", short_help="every fault at every moment, in virtual time")
@click.argument("tool", required=False, metavar="[TOOL]", type=PathName())
@playing_options("matrix", "what was played, the report and the FMEA")
@click.option(
    "--every",
    type=click.IntRange(1),
    default=1,
    show_default=True,
    metavar="N",
    help="Play one cell of N, spread over all faults, moments and commands; the others are counted as left out.",
)
@click.option("--only", default="", metavar="TEXT", help="Play the cells whose id has this text only.")
@click.option("--cell", metavar="ID", help="Play this cell only, with its recording and its figure.")
@click.option("--list", "listed", is_flag=True, help="Print the ids of the cells, and play none.")
def command(
    tool: Path | None,
    output: Path,
    jobs: int | None,
    scheduler: str | None,
    every: int,
    only: str,
    cell: str | None,
    listed: bool,
    as_json: bool,
) -> None:
    """Play every fault of the testbench at every moment of a grip and a drop, with every command, in virtual time.

    After its fault is removed, a cell ends with a grip and a drop. The rules of `eehal campaign` judge it. FOLDER
    receives report.html, report.json, cells.jsonl and fmea.csv, the failure modes and effects of the tool, with empty
    columns for severity and occurrence.

    A cell's id is "FAULT @ MOMENT + COMMAND". Without TOOL the shipped one is played. Exit code 4: a rule is broken,
    for example because a part was dropped.
    """
    from end_effector_hal.codecs import load_tool
    from end_effector_hal.description import profile_path
    from end_effector_lab.workers import open_workers

    description = load_tool(tool or profile_path())
    if cell is not None and (jobs or scheduler or only or every > 1 or listed):
        raise UsageError(
            "--cell plays one cell in this process.",
            todo="Leave --jobs, --scheduler, --only, --every and --list out.",
        )
    if cell is not None:
        raise SystemExit(_one(description, _whole(description, as_json), cell, output, as_json=as_json))
    if listed:
        click.echo("\n".join(each.id for each in _chosen(_whole(description, as_json), only, every)))
        return
    with open_workers(scheduler, jobs) as workers:  # first of all: a scheduler may not be there
        whole = _whole(description, as_json)
        cells = _chosen(whole, only, every)
        code = _all(description, cells, len(whole) - len(cells), output, workers, as_json=as_json)
    raise SystemExit(code)


def _whole(description: Description, as_json: bool) -> list[Cell]:
    from end_effector_lab.trials import cells_of, moments

    with Progress("Playing the run without a fault", shown=not as_json):
        return list(cells_of(description, moments(description)))


def _chosen(whole: list[Cell], only: str, every: int) -> list[Cell]:
    from end_effector_lab.trials import thinned

    chosen = [each for each in whole if only in each.id]
    if not chosen:
        raise UsageError(f"No cell has {only!r} in its id.", todo="--list prints them.")
    return thinned(chosen, every)


def _all(
    description: Description,
    cells: list[Cell],
    left_out: int,
    output: Path,
    workers: Workers,
    *,
    as_json: bool,
) -> int:
    from end_effector_lab.results import new_results
    from end_effector_lab.trials import CELLS, FIGURES, FMEA, PAGE, figures, fmea, page, play_all

    folder = new_results(output)
    with Progress(f"{len(cells)} cells", shown=not as_json) as progress:
        told = counted(progress, "cells")
        played = play_all(description, cells, workers=workers, lines=folder / CELLS, on_progress=told)
    found = figures(cells, played.values(), left_out)
    write_whole(folder / PAGE, page(description.name, found, cells, played).encode())
    write_whole(folder / FIGURES, (json.dumps(found, indent=1) + "\n").encode())
    write_whole(folder / FMEA, fmea(description, cells, played).encode())
    if as_json:
        click.echo(json_text(found))
    else:
        _tell(found, [each for each in played.values() if each.objections], output)
    return 4 if found["dropped"] or found["unexplained"] else 0


def _tell(found: dict[str, Any], wrong: list[Played], output: Path) -> None:
    from end_effector_lab.trials import let_go

    click.echo(" x ".join(f"{count} {name}" for name, count in found["dimensions"].items()))
    for name, count in found["outcomes"].items():
        click.echo(f"{count:7} {name}")
    for each in wrong[:20]:
        said = f"{each.id}: {each.outcome}; {'; '.join(each.objections)}"
        click.echo(f"not explained: {printable(said, 5000)}")
    click.echo(
        f"{found['cells']} cells, {found['dropped']} dropped, {let_go(found)}{found['unexplained']} unexplained, "
        f"{found['left_out']} left out; {output / 'report.html'}"
    )


def _one(description: Description, cells: list[Cell], name: str, output: Path, *, as_json: bool) -> int:
    from difflib import get_close_matches

    from end_effector_hal.cli import figures
    from end_effector_lab.figures import RecordedRun
    from end_effector_lab.results import new_results
    from end_effector_lab.trials import disturbances, record

    cell = next((each for each in cells if each.id == name), None)
    if cell is None:
        close = get_close_matches(name, [each.id for each in cells], n=1, cutoff=0.3)
        raise UsageError(f"There is no cell {name!r}.", todo=f"Did you mean {close[0]!r}?" if close else "")
    drawing = figures()  # without what draws them nothing is played
    folder = new_results(output / "cell")
    played = record(description, cell, folder)
    run = replace(RecordedRun.read(folder / "states.csv"), marks=disturbances(cell))
    figure = drawing.save(run.figure("timeline"), folder / "timeline.png")
    if as_json:
        print_document(asdict(played) | {"figure": str(figure)})
    else:
        click.echo(played.outcome)
        for objection in played.objections:
            click.echo(f"not explained: {objection}")
        if played.told:
            click.echo(f"after {played.told_after:g} s: {played.told}")
        click.echo(str(figure))
    return 4 if played.objections else 0
