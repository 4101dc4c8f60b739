"""``eehal model simulate``: plays runs of the whole network, as UPPAAL's simulator does."""

from __future__ import annotations

import sys
from math import isnan
from pathlib import Path
from random import Random

import click

from end_effector_hal.cli._lab import Drawing, draw_run, figures, is_figure
from end_effector_hal.cli._options import drawing_option, the_folder
from end_effector_hal.cli._output import Progress, print_document
from end_effector_hal.cli.model._source import NamedNetwork, Source, network_options
from end_effector_hal.control import word_of
from end_effector_hal.errors import UsageError
from end_effector_hal.recording import MODEL_RUN, check_replaceable
from end_effector_hal.verification import has_states, states_of, write_run
from timed_automata import Trace, TraceStep
from timed_automata.simulate import parse_choices
from timed_automata.simulate import simulate as play

_LONGEST_S = 1e7
NO_STATES = "The model has no variables ee, command and actuator[], so there is no figure."


@click.command(short_help="Play runs of the network, at random or guided.")
@network_options("model", "coils", "registers", "deaths")
@click.option("--seed", default=0, show_default=True, help="The same seed, the same run.")
@click.option("--steps", type=click.IntRange(0), help="Largest number of transitions; by default 100.")
@click.option(
    "--for", "seconds", type=click.FloatRange(0, _LONGEST_S), metavar="SECONDS", help="Length of the run."
)
@click.option("--choose", default="", metavar="'…; …'", help="What happens first; see above.")
@drawing_option(
    "Folder for run.txt, states.csv, events.csv, run.json and the timeline; or the file of the timeline alone."
)
@click.option("--json", "as_json", is_flag=True, help="Print the run as JSON.")
def simulate(
    network: NamedNetwork,
    seed: int,
    steps: int | None,
    seconds: float | None,
    choose: str,
    output: Path | None,
    as_json: bool,
) -> None:
    """Play the whole network at random, or as --choose directs: a line per transition, time in ms.

    --choose "world == IN_TIME; adopt; grip @ 1000; confirmed[0] + 350": each item is the name of a channel, or a
    condition that the next transition makes true, and its time in ms: @ after the start, + after the previous item;
    without a time, as soon as possible. Transitions that cannot wait happen in between by themselves. The run ends
    after the last item unless --steps or --for continues it at random.
    """
    if output is not None and is_figure(output):
        figures()  # without what draws them nothing is played
    elif output is not None:
        check_replaceable(output)
    source = network.open()
    choices = parse_choices(source.network, choose)
    if seconds is not None and isnan(seconds):  # what a range of click lets through
        raise UsageError("--for nan is no length of time.")
    until = None if seconds is None else round(seconds * 1_000_000)
    with Progress("Playing the run", shown=not as_json):
        run = play(source.network, Random(seed), choices, steps=steps, until=until)
    files, note = ([], "") if output is None else _written(source, run.trace, seed, output)
    if as_json:
        print_document(_document(source, run.trace, seed, files, note))
    else:
        click.echo("\n".join(run.trace.lines))
        for file in files:
            click.echo(str(file))
        if note:
            click.echo(f"Note: {note}", err=True)
    if run.error is not None:
        click.echo(str(run.error), err=True)
        sys.exit(run.error.exit_code)


def _written(source: Source, trace: Trace, seed: int, output: Path) -> tuple[list[Path], str]:
    """Write the files of a run; return them, and the reason if there is no figure."""
    names = source.description.sequence if source.description is not None else ()
    scenario = f"{MODEL_RUN}, seed {seed}"
    run = (states_of(trace, names), source.run_info(scenario)) if has_states(source.network) else None
    if is_figure(output):
        if run is None:
            raise UsageError(NO_STATES, where=str(output), todo="Name a folder: it gets the run as text.")
        return [draw_run(*run, output)], ""
    draw = Drawing()
    files = write_run(the_folder(output), trace.lines, run, draw)
    return files, NO_STATES if run is None else draw.note


def _document(source: Source, trace: Trace, seed: int, files: list[Path], note: str) -> dict[str, object]:
    return {
        "source": source.name,
        "seed": seed,
        "steps": [_step(source, step) for step in trace.steps],
        "end_ms": float(trace.end),
        "remark": trace.remark,
        "files": [str(file) for file in files],
        "notes": [note] if note else [],
    }


def _step(source: Source, step: TraceStep) -> dict[str, object]:
    processes, tool = source.network.processes, source.description
    words = {
        change.name: [word_of(tool, change.name, change.old), new]
        for change in step.changes
        if tool is not None and (new := word_of(tool, change.name, change.new)) is not None
    }
    return {
        "at_ms": float(step.at),
        "channel": step.channel,
        "edges": [
            {
                "process": processes[edge.process].name,
                "source": processes[edge.process].locations[edge.source].name,
                "target": processes[edge.process].locations[edge.target].name,
                "selected": dict(edge.selected),
            }
            for edge in step.edges
        ],
        "changes": {change.name: [change.old, change.new] for change in step.changes},
        "words": words,
    }
