"""``eehal campaign``: random sequences of commands, faults and deaths, in virtual time."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from end_effector_hal.cli import PathName, Progress, json_text, print_document, seed_option, write_whole
from end_effector_hal.errors import UsageError
from end_effector_hal.vocabulary import printable

from ._options import TimeLeft, playing_options

if TYPE_CHECKING:
    from end_effector_hal.description import Description
    from end_effector_lab.trials import Campaign
    from end_effector_lab.workers import Workers

RUNS = 1000
MOST_LISTED, MOST_SHOWN = 20, 5000


@click.command("campaign", short_help="random commands, faults and deaths, in virtual time")
@click.argument("tool", required=False, metavar="[TOOL]", type=PathName())
@playing_options("campaign", "what was played, the failures and what was never reached")
@click.option(
    "--runs", type=click.IntRange(1), metavar="N", help=f"End after N runs in all.  [default: {RUNS}]"
)
@click.option(
    "--time",
    "seconds",
    type=click.FloatRange(min=0, min_open=True),
    metavar="S",
    help="Begin no run after S seconds; what failed is then made smaller, for up to a minute each.",
)
@seed_option(default=0, help="Seed of all cases: the same seed gives the same runs.  [default: 0]")
@click.option("--play", "file", metavar="FILE", type=PathName(), help="Play the case in FILE only.")
def command(
    tool: Path | None,
    output: Path,
    runs: int | None,
    seconds: float | None,
    seed: int,
    jobs: int | None,
    scheduler: str | None,
    file: Path | None,
    as_json: bool,
) -> None:
    """Play random sequences of commands, faults, deaths and restarts in virtual time, and judge each of them.

    The requirements are computed from the description, by rules that share no code with the controller; the monitor
    judges each run as well, and each run ends with a grip and a drop after all faults are removed. Runs that reach an
    edge of the automata, or an edge with a fault, for the first time are kept, and later runs are mutants of them.

    FOLDER receives runs.jsonl, unreached.json and, in failures/, the smallest case of each kind of failure, which
    --play plays. Without TOOL: the shipped one. Exit code 4: a run has failed.
    """
    from end_effector_hal.codecs import load_tool
    from end_effector_hal.description import profile_path
    from end_effector_lab.workers import open_workers

    description = load_tool(tool or profile_path())
    if file is not None and (jobs or scheduler):
        raise UsageError("--play plays one case in this process.", todo="Leave --jobs and --scheduler out.")
    if file is not None:
        raise SystemExit(_play(description, file, as_json=as_json))
    limit = runs or (None if seconds else RUNS)
    with open_workers(scheduler, jobs) as workers:  # first of all: a scheduler may not be there
        raise SystemExit(_run(description, output, limit, seconds, seed, workers, as_json=as_json))


def _run(
    description: Description,
    output: Path,
    runs: int | None,
    seconds: float | None,
    seed: int,
    workers: Workers,
    *,
    as_json: bool,
) -> int:
    from end_effector_lab.trials import (
        UNREACHED,
        never_reached,
        read_failures,
        run_campaign,
        summary,
    )

    left = TimeLeft()
    what = f"{runs} runs" if runs else f"runs for {seconds:g} s"
    with Progress(what, shown=not as_json) as progress:

        def go_on(_: Campaign, run: int) -> bool:
            in_time = seconds is None or left.passed_s < seconds
            return in_time and (runs is None or run < runs)

        def on_progress(campaign: Campaign) -> None:
            by_runs = left(campaign.runs, runs) if runs else float("inf")
            by_time = seconds - left.passed_s if seconds else float("inf")
            edges = f"{len(campaign.reached.edges)}/{len(campaign.known.edges)} edges"
            progress(
                f"{campaign.runs} of {what}, {edges}, {campaign.failures} failures, "
                f"{max(0.0, min(by_runs, by_time)) / 60:.0f} min left"
            )

        campaign = run_campaign(description, output, workers, seed=seed, go_on=go_on, on_progress=on_progress)
    found, unreached = summary(campaign), never_reached(campaign)
    write_whole(output / UNREACHED, (json.dumps(unreached, indent=1) + "\n").encode())
    if as_json:
        click.echo(json_text(found))
    else:
        for name in unreached["edges"][:MOST_LISTED]:
            click.echo(f"never taken: {name}")
        for each in read_failures(output / "failures"):
            click.echo(printable(f"failed: {each['kind']}: {each['words']}; {each['file']}", MOST_SHOWN))
        click.echo(
            f"{found['runs']} runs, {found['failures']} failures of {found['kinds']} kinds, {found['grips']} grips, "
            f"{found['edges']} edges, {found['locations']} locations, {found['edge_faults']} edges with a fault; "
            f"{output / UNREACHED}"
        )
    return 4 if found["failures"] else 0


def _play(description: Description, file: Path, *, as_json: bool) -> int:
    from end_effector_lab.trials import no_log, play_case, read_case

    case = read_case(file, description)
    with no_log():
        played = play_case(description, case)
    if as_json:
        print_document(case.as_json() | played.as_json())
    else:
        for line in played.log():
            click.echo(line)
        for what in played.failures.values():
            click.echo(f"failed: {what}")
        click.echo(f"{'' if played.failures else 'nothing is wrong; '}it ended: {played.end}")
    return 4 if played.failures else 0
