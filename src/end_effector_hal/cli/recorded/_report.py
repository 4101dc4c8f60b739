"""``eehal report``: a recording as one HTML file."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

import click

from end_effector_hal.cli._json_output import print_document
from end_effector_hal.cli._options import PathName, refuse_inputs, write_whole
from end_effector_hal.cli._progress import Progress
from end_effector_hal.errors import UsageError

from ._recordings import open_recordings, part_of, recording_options

SUFFIXES = (".html", ".htm")


@click.command("report")
@click.argument("recordings", metavar="RECORDING [RECORDING]", nargs=-1, required=True, type=PathName())
@click.option("-o", "--output", metavar="FILE.html", type=PathName(), help="Default: NAME.html here.")
@recording_options
@click.option("--json", "as_json", is_flag=True, help="Print {ok, exit_code, file, recordings} as JSON.")
def command(
    recordings: tuple[Path, ...],
    output: Path | None,
    description: Path | None,
    other: Path | None,
    since: float | None,
    until: float | None,
    as_json: bool,
) -> None:
    """Write RECORDING as one HTML file with everything inside: it opens anywhere, and asks no other host.

    It is the page of `eehal page RECORDING`: what happened, why a grip failed, times against the worst cases, what the
    replay says, and every moment to scrub through. With a second recording both are compared.

    Exit code 0: written, and the replay agrees; 1: written, and it does not, or something cannot be read.
    """
    from end_effector_hal.page import report_html
    from end_effector_hal.page.recorded import judge_recording, read_recording

    if output is not None:
        _check_name(output, recordings, [each for each in (description, other) if each is not None])
    files = open_recordings(recordings, description, other)
    part = part_of(since, until)
    contents, verdicts = [], []
    for each in files:
        with Progress(f"reading {each.name}", shown=not as_json) as progress:
            contents.append(read_recording(each, part, partial(_tell, progress, each.name)))
            progress(f"judging {each.name}")
            verdicts.append(judge_recording(each))
    title = " and ".join(each.name for each in files)
    target = output or Path(f"{'-'.join(each.path.resolve().stem for each in files)}.html")
    write_whole(target, report_html(title, contents, verdicts).encode())
    code = int(any(verdict["ok"] is False for verdict in verdicts) or not all(each.whole for each in files))
    told = [
        {
            "name": content["recording"]["name"],
            "story": content["summary"]["story"],
            "replay_ok": verdict["ok"],
            "replay": verdict["text"],
            "notes": content["recording"]["notes"],
        }
        for content, verdict in zip(contents, verdicts, strict=True)
    ]
    if as_json:
        print_document({"ok": not code, "exit_code": code, "file": str(target), "recordings": told})
        raise click.exceptions.Exit(code)
    click.echo(str(target))
    for one in told:
        click.echo(f"{one['name']}: {one['story']}. {one['replay']}")
        for note in one["notes"]:
            click.echo(f"Note: {note}", err=True)
    raise click.exceptions.Exit(code)


def _check_name(output: Path, recordings: Sequence[Path], others: Sequence[Path]) -> None:
    """Raises UsageError when a report would replace something else."""
    plain = output.is_file() or not output.exists()  # else a pipe, or a terminal
    if plain and output.suffix.lower() not in SUFFIXES:
        raise UsageError(
            "A report is an HTML file.", where=str(output), todo="Name a file that ends with .html."
        )
    within = [each for folder in recordings if folder.is_dir() for each in folder.rglob("*")]
    recorded = [each for each in (*recordings, *within) if each.suffix.lower() not in SUFFIXES]
    refuse_inputs(output, (*recorded, *others))


def _tell(progress: Progress, name: str, share: float) -> None:
    progress(f"reading {name}, {share:.0%}")
