"""``eehal report``: writes a recording as one HTML file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from end_effector_hal.cli import PathName, Progress, print_document, refuse_inputs, write_whole
from end_effector_hal.cli.recorded import open_recordings, part_of, recording_options, runs_in
from end_effector_hal.errors import ReportedError, UsageError
from end_effector_hal.vocabulary import printable

if TYPE_CHECKING:
    from end_effector_hal.page.recorded import (
        FoldedRecording,
        RecordedTables,
        RecordingFiles,
        RecordingPart,
    )

SUFFIXES = (".html", ".htm")
MOST_RUNS, MOST_BYTES = 200, 64_000_000
"""Limits of one file: number of runs, and their total size in bytes."""
_FULL = f"one file holds {MOST_RUNS} runs or {MOST_BYTES // 1_000_000} MB. Report a folder of it."


@click.command("report", short_help="a recorded run as one HTML file")
@click.argument("recordings", metavar="RECORDING [RECORDING]", nargs=-1, required=True, type=PathName())
@click.option("-o", "--output", metavar="FILE.html", type=PathName(), help="Default: NAME.html here.")
@recording_options
@click.option("--json", "as_json", is_flag=True, help="Print {ok, exit_code, file, recordings} as JSON.")
def command(
    recordings: tuple[Path, ...],
    output: Path | None,
    description: Path | None,
    since: float | None,
    until: float | None,
    as_json: bool,
) -> None:
    """Write RECORDING as one HTML file with everything inside: it opens anywhere, and connects to no other host.

    It contains the page of `eehal page RECORDING`: the events, the reason for a failed grip, times against the worst
    cases, the result of the replay, and every moment to scrub through. With a second recording both are compared.

    RECORDING may also be a folder of runs at any depth: then the file begins with a table of them, and opens each. A
    run that cannot be read is listed with the reason.

    Exit code 0: written, and the replay agrees; 1: written, but the replay differs, or something cannot be read.
    """
    if output is not None:
        _check_name(output, recordings, [] if description is None else [description])
    part = part_of(since, until)
    if runs := runs_in(recordings[0]) if len(recordings) == 1 else ():
        html, told = _runs(recordings[0], runs, description, part, shown=not as_json)
        stem = recordings[0].resolve().stem
    else:
        html, told, stem = _one(open_recordings(recordings, description), part, shown=not as_json)
    target = output or Path(f"{stem}.html")
    write_whole(target, html.encode())
    code = int(any(not each.good for each in told))
    if as_json:
        document = [each.as_json() for each in told]
        print_document({"ok": not code, "exit_code": code, "file": str(target), "recordings": document})
        raise click.exceptions.Exit(code)
    click.echo(str(target))
    for each in told:
        click.echo(f"{each.name}: {each.story.removesuffix('.')}. {each.replay}".rstrip())
        for note in each.notes:
            click.echo(f"Note: {note}" if len(told) == 1 else f"Note, {each.name}: {note}", err=True)
    raise click.exceptions.Exit(code)


@dataclass(frozen=True)
class _Reported:
    """The printed result for one recording.

    Attributes:
        ok: whether the replay agrees; None if it cannot be judged.
        whole: whether all of the recording could be read.
    """

    name: str
    story: str
    ok: bool | None
    replay: str
    notes: list[str]
    whole: bool

    @property
    def good(self) -> bool:
        return self.ok is not False and self.whole

    def as_json(self) -> dict[str, object]:
        return {
            "name": self.name, "story": self.story, "replay_ok": self.ok, "replay": self.replay, "notes": self.notes,
        }  # fmt: skip


def _read(
    files: RecordingFiles | RecordedTables,
    part: RecordingPart,
    name: str,
    place: str,
    *,
    shown: bool,
) -> tuple[FoldedRecording, dict[str, Any], _Reported]:
    """Read and judge a recording; raises ReportedError."""
    from end_effector_hal.page.recorded import judge_recording, read_recording

    with Progress(f"reading {name}{place}", shown=shown) as progress:
        read = read_recording(files, part, lambda share: progress(f"reading {name}{place}, {share:.0%}"))
        progress(f"judging {name}{place}")
        verdict = judge_recording(files)
    story, notes = read.document["summary"]["story"], read.document["recording"]["notes"]
    return read, verdict, _Reported(name, story, verdict["ok"], verdict["text"], notes, files.whole)


def _one(
    files: Sequence[RecordingFiles | RecordedTables], part: RecordingPart, *, shown: bool
) -> tuple[str, list[_Reported], str]:
    """Report one recording, or compare two; return the HTML text, the printed results, and the file's stem."""
    from end_effector_hal.page.recorded import compare_recordings
    from end_effector_lab.recorded import report_html

    reads, verdicts, told = zip(
        *(_read(each, part, each.name, "", shown=shown) for each in files), strict=True
    )
    title = " and ".join(each.name for each in files)
    stem = "-".join(each.path.resolve().stem for each in files)
    compared = [each.compared for each in reads]
    with Progress("comparing", shown=shown):
        differences = compare_recordings(*compared) if len(compared) == 2 else None
    html = report_html(title, [each.document for each in reads], list(verdicts), differences)
    return html, list(told), stem


def _runs(
    folder: Path, runs: Sequence[Path], description: Path | None, part: RecordingPart, *, shown: bool
) -> tuple[str, list[_Reported]]:
    """Report many runs in one file; a run that cannot be read, or that exceeds the limits, appears only in
    the table.
    """
    from end_effector_lab.recorded import report_data, runs_html

    rows: list[dict[str, Any]] = []
    kept: dict[int, bytes] = {}
    told: list[_Reported] = []
    for number, run in enumerate(runs):
        name, place = str(run.relative_to(folder)), f" ({number + 1} of {len(runs)})"
        row = {"name": printable(name), "started": "", "tool": "", "length_s": None}
        try:
            if len(kept) >= MOST_RUNS or sum(map(len, kept.values())) >= MOST_BYTES:
                found = _Reported(name, f"Not read: {_FULL}", None, "", [], False)
            else:
                files = open_recordings([run], description)[0]
                read, verdict, found = _read(files, part, name, place, shown=shown)
                content = read.document
                kept[number] = report_data([content], [verdict])
                recording = content["recording"]
                row |= {
                    "started": recording["started"],
                    "tool": content["drawn"]["name"],
                    "length_s": recording["end_s"] - recording["begin_s"],
                }
        except UsageError as error:  # without its place on this machine: the report may be mailed
            found = _Reported(
                name, f"Cannot be read: {error.what} {error.todo}".strip(), False, "", [], False
            )
        except ReportedError as error:
            found = _Reported(name, f"Cannot be read: {error}", False, "", [], False)
        told.append(found)
        ok = found.ok and found.whole  # None: nobody can say
        said = (found.replay.removeprefix("Replay and monitor: "), "" if found.whole else "It is not whole.")
        replay = " ".join(filter(None, said)) if found.replay else "not read"
        rows.append(row | {"story": found.story, "ok": ok, "replay": replay})
    return runs_html(folder.resolve().name, rows, kept), told


def _check_name(output: Path, recordings: Sequence[Path], others: Sequence[Path]) -> None:
    """Raise UsageError if the report would replace a file that is no report."""
    plain = output.is_file() or not output.exists()  # else a pipe, or a terminal
    if plain and output.suffix.lower() not in SUFFIXES:
        raise UsageError(
            "A report is an HTML file.", where=str(output), todo="Name a file that ends with .html."
        )
    within = [each for folder in recordings if folder.is_dir() for each in folder.rglob("*")]
    recorded = [each for each in (*recordings, *within) if each.suffix.lower() not in SUFFIXES]
    refuse_inputs(output, (*recorded, *others))
