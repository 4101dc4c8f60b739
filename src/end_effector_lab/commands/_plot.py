"""``eehal plot``: draws figures of a recording."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from end_effector_hal.cli import PathName, Progress, figures, print_document
from end_effector_hal.errors import UsageError, os_errors

from ._compare import states_in

if TYPE_CHECKING:
    from end_effector_lab.figures import RecordedRun

STYLES = ("timeline", "paper")
"""The styles of the figures, repeated here so that help does not load the drawing module."""


@click.command("plot", short_help="draw a recorded run")
@click.argument("recording", metavar="STATES.csv", type=PathName())
@click.option("--style", type=click.Choice([*STYLES, "both"]), default="timeline", show_default=True)
@click.option("-o", "--output", metavar="FILE.(png|svg)|DIR", type=PathName())
@click.option("--json", "as_json", is_flag=True, help="Print the story and the files as JSON.")
def command(recording: Path, style: str, output: Path | None, as_json: bool) -> None:
    """Draw a recording: STATES.csv, or the folder of a run.

    Pressures and the source of the run are read from pressures.csv and run.json beside it. Without -o the figure is
    written beside the recording, as PNG and as SVG.
    """
    from end_effector_lab.figures import RecordedRun

    drawing = figures()  # without what draws them nothing is read or written
    states = states_in(recording)
    styles = STYLES if style == "both" else (style,)
    files: list[Path] = []
    with Progress(f"Reading {states}", shown=not as_json) as progress:
        run = RecordedRun.read(states)
        targets = {name: _targets(states, name, styles, output) for name in styles}
        for name, paths in targets.items():
            progress(f"Drawing the {name}")
            figure = run.figure(name)
            files += [drawing.save(figure, path) for path in paths]
    _report(run, files, as_json)


def _targets(states: Path, style: str, styles: tuple[str, ...], output: Path | None) -> list[Path]:
    if output is None:
        return [states.with_name(f"{style}.{suffix}") for suffix in ("png", "svg")]
    if output.suffix and not output.is_dir():
        if len(styles) > 1:
            raise UsageError(
                "Two figures do not fit into one file.", where=str(output), todo="Name a folder."
            )
        return [output]
    with os_errors("The folder cannot be made", output):
        output.mkdir(parents=True, exist_ok=True)
    return [output / f"{style}.{suffix}" for suffix in ("png", "svg")]


def _report(run: RecordedRun, files: list[Path], as_json: bool) -> None:
    from end_effector_hal.recording import read_story

    story = read_story(run.log, run.info)
    if as_json:
        answer = {
            "verdict": story.verdict,
            "final": story.final.name if story.final is not None else None,
            "grips": [asdict(grip) for grip in story.grips],
            "releases": [
                {**asdict(release), "ended": release.ended.name if release.ended is not None else None}
                for release in story.releases
            ],
            "missed": [{"time_s": moment.time_s, "text": moment.text} for moment in run.missed],
            "rows": len(run.log.rows),
            "files": [str(file) for file in files],
            "notes": list(run.notes),
        }
        print_document(answer)
        return
    click.echo(story.verdict)
    for moment in run.missed:
        click.echo(f"At {moment.time_s:.3f} s: {moment.text}")
    for file in files:
        click.echo(str(file))
    for note in run.notes:
        click.echo(f"Note: {note}", err=True)
