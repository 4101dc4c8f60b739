"""``eehal replay``: a recorded run, decided once more and judged."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from end_effector_hal.errors import UsageError

from ._options import PathName

if TYPE_CHECKING:
    from end_effector_hal.verification.replay import Review, SegmentEnd


@click.command(name="replay")
@click.argument("recording", metavar="TRACE.mcap|FOLDER", type=PathName())
@click.option(
    "--description",
    metavar="FILE",
    type=PathName(),
    help="Replay with this tool and its automata instead of those that were recorded.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the findings as JSON.")
def command(recording: Path, description: Path | None, as_json: bool) -> None:
    """Feed a recorded run to the same controller, and judge it by its network.

    Says whether the controller decides the same, with the first difference, and whether what was recorded is a run of
    the automata: guards, synchronisation, order, time, and the requirements that can be judged on a run. A reaction
    bound that was missed and told is shown and is no difference. A trace of a folder that cannot be read is told, and
    the others are judged all the same.

    Exit code 0: the same, and a run of its network; 1: not; 2: no recording, or a trace of it cannot be read.
    """
    from end_effector_hal.codecs import load_tool
    from end_effector_hal.verification.replay import load_trace, review, traces_of

    tool = load_tool(description) if description is not None else None
    paths = traces_of(recording)
    reviews: list[Review] = []
    refused: list[dict[str, object]] = []
    before: SegmentEnd | None = None
    for path in paths:
        try:
            reviews.append(review(load_trace(path), tool, before))
            before = reviews[-1].end
        except UsageError as error:
            if len(paths) == 1:
                raise
            refused.append(
                {"trace": str(path), "ok": False, "faults": [each.as_json() for each in error.diagnostics]}
            )
            click.echo(str(error), err=True)
        else:
            if not as_json:
                _tell(reviews[-1])
    if as_json:
        found = [*(each.as_json() for each in reviews), *refused]
        click.echo(json.dumps(found, indent=2, ensure_ascii=False))
    if not all(each.ok for each in reviews):
        raise click.exceptions.Exit(1)
    if refused:
        raise click.exceptions.Exit(UsageError.exit_code)


def _tell(review: Review) -> None:
    trace, replay = review.trace, review.replay
    header = trace.header
    version = f"version {header.version}, " if header.version else ""
    click.echo(
        f"{trace.file.path}: {header.program} of {header.description} ({version}{header.hash}), "
        f"{trace.seconds(trace.last_at):.3f} s, {replay.inputs} inputs"
    )
    if replay.difference is None:
        click.echo(f"  replay: decides the same, {replay.compared} times")
    else:
        at = trace.seconds(replay.difference.at)
        click.echo(f"  replay: DIFFERS at {at:.6f} s: {replay.difference}")
    held = f"{review.requirements} requirements of the file were judged"
    if not review.objections:
        click.echo(f"  monitor: a run of the network, {review.steps} steps; {held} and held")
    else:
        click.echo(f"  monitor: {review.steps} steps; {held}")
    for objection in review.objections:
        click.echo(f"    at {trace.seconds(objection.at):.6f} s, {objection.kind}: {objection.what}")
    for note in review.notes:
        click.echo(f"  note: {note}")
