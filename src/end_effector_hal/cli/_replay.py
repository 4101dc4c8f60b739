"""``eehal replay``: runs the same program on recorded inputs, and compares and judges its decisions."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import click

from end_effector_hal.errors import UsageError

from ._options import PathName
from ._output import Progress, print_document, print_table

if TYPE_CHECKING:
    from end_effector_hal.description import Description
    from end_effector_hal.verification.replay import Review, SegmentEnd


@click.command(name="replay")
@click.argument("recording", metavar="TRACE.mcap|FOLDER", type=PathName())
@click.option(
    "--description",
    metavar="FILE",
    type=PathName(),
    help="Replay with this tool and its automata instead of those that were recorded.",
)
@click.option("--json", "as_json", is_flag=True, help="Print {ok, traces} as JSON.")
def command(recording: Path, description: Path | None, as_json: bool) -> None:
    """Feed a recorded run to the same controller, and judge it by its network.

    The command prints whether the decisions are identical, with the first difference, and whether the automata allow
    each recorded step: guards, synchronisation, order, time, and the requirements that can be judged on a run. Lines,
    last wills and the header are checked against the decisions and the rest of the trace. A missed reaction bound that
    the trace records is listed, but does not count as a difference. A trace in a folder that cannot be read is listed,
    and the others are judged nevertheless.

    FOLDER may also contain folders of runs at any depth: then only differences are printed, and a table follows at the
    end.

    With --description the first decision that the other tool would have made differently is printed. Later decisions
    are not compared, because the recorded readings answer the outputs of the recorded tool.

    Exit code 0: identical, and every step allowed; 1: not; 2: no recording, or a trace of it cannot be read.
    """
    from end_effector_hal.codecs import load_tool
    from end_effector_hal.verification.replay import runs_of

    tool = load_tool(description) if description is not None else None
    folders = runs_of(recording)
    many = folders != (recording,)
    runs: list[_Run] = []
    for number, folder in enumerate(folders, start=1):
        place = f" ({number} of {len(folders)})" if many else ""
        runs.append(_Run(str(folder.relative_to(recording)) if many else str(folder)))
        for path, found in _judged(folder, tool, place, shown=not as_json):
            if isinstance(found, UsageError):
                if path == recording:
                    raise found
                runs[-1].refused[path] = found
                click.echo(str(found), err=True)
            else:
                runs[-1].reviews.append(found)
                if not as_json and not (many and found.ok):
                    _tell(found)
    ok = all(each.ok for run in runs for each in run.reviews)
    refused = [each for run in runs for each in run.refused]
    if as_json:
        print_document({"ok": ok and not refused, "traces": [each for run in runs for each in run.as_json()]})
    elif many:
        _print_table(runs)
    if not ok:
        raise click.exceptions.Exit(1)
    if refused:
        raise click.exceptions.Exit(UsageError.exit_code)


@dataclass
class _Run:
    """The results for one folder, with its name."""

    name: str
    reviews: list[Review] = field(default_factory=list)
    refused: dict[Path, UsageError] = field(default_factory=dict)

    @property
    def verdict(self) -> str:
        if (wrong := [each for each in self.reviews if not each.ok]) or self.refused:
            first = next((each.replay.difference for each in wrong if each.replay.difference), None)
            said = "DIFFERS" if first else "no run of its network, or damaged" if wrong else ""
            return ", ".join(filter(None, (said, f"{len(self.refused)} unreadable" if self.refused else "")))
        return "the same"

    def as_json(self) -> Iterator[dict[str, object]]:
        yield from (each.as_json() for each in self.reviews)
        for path, error in self.refused.items():
            faults = [each.as_json() for each in error.diagnostics]
            yield {"trace": str(path), "ok": False, "faults": faults}


def _judged(
    folder: Path, tool: Description | None, place: str, *, shown: bool
) -> Iterator[tuple[Path, Review | UsageError]]:
    """Yield the review of each trace of a run in the order of writing, or an error for a trace that cannot be read."""
    from end_effector_hal.verification.replay import load_trace, review, traces_of

    before: SegmentEnd | None = None
    try:
        paths = traces_of(folder)
    except UsageError as error:  # one of many that cannot be read
        yield folder, error
        return
    for path in paths:
        try:
            with Progress(f"Replaying {path}{place}", shown=shown):
                found = review(load_trace(path), tool, before)
        except UsageError as error:
            yield path, error
        else:
            before = found.end
            yield path, found


def _print_table(runs: list[_Run]) -> None:
    from rich.table import Table

    table = Table("run", box=None, pad_edge=False)
    for column in ("traces", "seconds", "inputs", "decisions"):
        table.add_column(column, justify="right")
    table.add_column("replay")
    for run in runs:
        seconds = max((each.trace.seconds(each.trace.last_at) for each in run.reviews), default=0.0)
        table.add_row(
            run.name, str(len(run.reviews) + len(run.refused)), f"{seconds:.1f}",
            str(sum(each.replay.inputs for each in run.reviews)),
            str(sum(each.replay.compared for each in run.reviews)), run.verdict,
        )  # fmt: skip
    print_table(table)
    same = sum(run.verdict == "the same" for run in runs)
    click.echo(f"{len(runs)} runs: {same} identical, {len(runs) - same} not identical or unreadable")


def _tell(review: Review) -> None:
    trace, replay = review.trace, review.replay
    header = trace.header
    version = f"version {header.version}, " if header.version else ""
    click.echo(
        f"{trace.file.path}: {header.description} ({version}{header.hash}), "
        f"{trace.seconds(trace.last_at):.3f} s, {replay.inputs} inputs"
    )
    if replay.difference is None:
        click.echo(f"  replay: {replay.compared} decisions, all identical")
    else:
        at = trace.seconds(replay.difference.at)
        click.echo(f"  replay: DIFFERS at {at:.6f} s: {replay.difference}")
    held = f"{review.requirements} requirements of the file were judged"
    if not review.objections:
        click.echo(f"  monitor: {review.steps} steps, all allowed by the automata; {held} and held")
    else:
        click.echo(f"  monitor: {review.steps} steps; {held}")
    for objection in review.objections:
        click.echo(f"    at {trace.seconds(objection.at):.6f} s, {objection.kind}: {objection.what}")
    for note in review.notes:
        click.echo(f"  note: {note}")
