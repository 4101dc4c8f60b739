"""``eehal replay``: a recorded run, decided once more and judged."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from end_effector_hal.tool.replay import Review


@click.command(name="replay")
@click.argument("recording", metavar="TRACE.mcap|FOLDER", type=click.Path(path_type=Path))
@click.option(
    "--description",
    metavar="FILE",
    type=click.Path(path_type=Path),
    help="Replay with this tool and its automata instead of those that were recorded.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the findings as JSON.")
def command(recording: Path, description: Path | None, as_json: bool) -> None:
    """Feed a recorded run to the same controller, and judge it by its network.

    Says whether the controller decides the same, with the first difference, and whether what was recorded is a run of
    the automata: guards, synchronisation, order, time, and the requirements that can be judged on a run. A reaction
    bound that was missed and told is shown and is no difference.

    Exit code 0: the same, and a run of its network; 1: not; 2: not a recording.
    """
    from end_effector_hal.tool.replay import load_trace, review, traces_of
    from end_effector_hal.wires import load_tool

    tool = load_tool(description) if description is not None else None
    reviews = [review(load_trace(path), tool) for path in traces_of(recording)]
    if as_json:
        click.echo(json.dumps([each.as_json() for each in reviews], indent=2, ensure_ascii=False))
    else:
        for each in reviews:
            _tell(each)
    if not all(each.ok for each in reviews):
        raise click.exceptions.Exit(1)


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
