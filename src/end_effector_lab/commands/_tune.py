"""``eehal tune``: tries other thresholds and time-outs on recorded grips."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import click

from end_effector_hal.cli import PathName, Progress, print_document, print_table
from end_effector_hal.cli.recorded import open_recordings
from end_effector_hal.errors import UsageError
from end_effector_hal.vocabulary import display_name

if TYPE_CHECKING:
    from end_effector_hal.description import Description
    from end_effector_hal.page.recorded import RecordedTables, RecordingFiles
    from end_effector_lab.recorded import GripCollector, Tried, Tuning

MOST_RECORDINGS = 2000


@click.command("tune", short_help="what recorded grips would have become with other thresholds and time-outs")
@click.argument("recordings", metavar="RECORDING…", nargs=-1, required=True, type=PathName())
@click.option(
    "--description",
    metavar="FILE",
    type=PathName(),
    help="Whose values are today's; a bag holds none.  [default: the one that was recorded]",
)
@click.option("--all", "every", is_flag=True, help="Print every value that was tried.")
@click.option("--json", "as_json", is_flag=True, help="Print {ok, grips, parameters, …} as JSON.")
def command(recordings: tuple[Path, ...], description: Path | None, every: bool, as_json: bool) -> None:
    """List what recorded grips would have become with other thresholds and time-outs.

    RECORDING is a folder of `eehal run --record`, a folder of such folders, one of their traces, or a ROS bag. Each
    number of each actuator is tried alone, from a fraction of its value to twice as much, on what the sensors showed
    while the recorded tool had that actuator active:

    \b
    failed     none of the recorded attempts would have been confirmed within the time-out
    late       confirmed on a later attempt, or later than today by more than the reaction bound
    lost       confirmed, and lost within the same hold
    stuck      not proven gone when the wait of the release was over
    undecided  the recording ends that attempt or that release before it is known

    A recording contains only attempts that were made: a grip that failed here might succeed on a further one. Nothing
    is suggested; the range in which nothing changes rests on the grips that were recorded, and on no others.

    Exit code 0: the table; 2: no recording, none with a grip, or one cannot be read.
    """
    from end_effector_lab.recorded import tune

    with Progress("Reading", shown=not as_json) as progress:
        read = _read(recordings, description, progress)
    if not read.collector.grips:
        raise UsageError(
            "The recording contains no grip.",
            where=str(recordings[0]),
            todo="; ".join(read.notes) or "Record some: `eehal run --record`.",
        )
    with Progress("Trying values", shown=not as_json) as progress:
        found = tune(
            read.collector.grips, read.tool, read.tools, lambda share: progress(f"Trying values: {share:.0%}")
        )
    if as_json:
        print_document({"ok": True, **found.as_json(), "recordings": read.names, "notes": read.notes})
    else:
        _print(found, read, every=every)


@dataclass
class _Read:
    """The recordings that were read: their names, the tool of each, and notes for the user."""

    collector: GripCollector
    tool: Description
    names: list[str] = field(default_factory=list)
    tools: list[Description] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    whose: str = ""


def _read(paths: tuple[Path, ...], description: Path | None, progress: Progress) -> _Read:
    from end_effector_hal.codecs import load_tool
    from end_effector_hal.description import content_hash
    from end_effector_lab.recorded import GripCollector

    today = load_tool(description) if description is not None else None
    read: _Read | None = None
    refused: dict[Path, UsageError] = {}
    for path in _runs(paths):
        progress(f"Reading {path}")
        try:
            files = _opened(path, description)
        except UsageError as error:  # one of many
            refused[path] = error
            continue
        if read is None:
            tool = today or files.description
            whose = (
                f"{description}" if today is not None else f"{tool.name} ({content_hash(tool)}), as recorded"
            )
            read = _Read(GripCollector(tool), tool, whose=whose)
        if why := _foreign(files.description, read.tool):
            read.notes.append(f"{path} is left out: {why}.")
            continue
        read.collector.collect(files.entries(), len(read.tools))
        read.names.append(str(path))
        read.tools.append(files.description)
        read.notes += [f"{path.name}: {note}" for note in files.notes]
        if read.collector.full:
            read.notes.append(f"There are too many grips: those after {path} is left out.")
            break
    if read is None:
        raise next(iter(refused.values()))
    read.notes += [f"{path} is left out: {error.what}" for path, error in refused.items()]
    others = {content_hash(each) for each in read.tools} - {content_hash(read.tool)}
    if others:
        read.notes.append(
            f"Recorded with other descriptions than today's as well: {', '.join(sorted(others)[:5])}."
        )
    return read


def _runs(paths: tuple[Path, ...]) -> Iterator[Path]:
    from end_effector_hal.verification.replay import runs_of

    found: dict[Path, None] = {}
    for path in paths:
        try:
            found |= dict.fromkeys(runs_of(path))
        except UsageError:
            found[path] = None  # tables or a bag, or what is refused when it is opened
    if len(found) > MOST_RECORDINGS:
        raise UsageError(
            f"{len(found)} recordings are too many.", where=str(paths[0]), todo=f"At most {MOST_RECORDINGS}."
        )
    yield from found


def _opened(path: Path, description: Path | None) -> RecordingFiles | RecordedTables:
    """Open a recording with the tool that was recorded in it, or else with the given description."""
    try:
        (found,) = open_recordings([path], None)
    except UsageError:
        if description is None:
            raise
        (found,) = open_recordings([path], description)
    return found


def _foreign(recorded: Description, tool: Description) -> str:
    """Return the reason why a recording belongs to another tool; empty if it belongs to this one."""
    if recorded.sequence != tool.sequence:
        return f"its actuators are {', '.join(recorded.sequence)}, and not {', '.join(tool.sequence)}"
    kinds = [(name, actuator.kind, tool.actuators[name].kind) for name, actuator in recorded.ordered]
    wrong = [f"{name} is a {theirs}, and not a {ours}" for name, theirs, ours in kinds if theirs != ours]
    return "; ".join(wrong)


def _print(found: Tuning, read: _Read, *, every: bool) -> None:
    from rich.table import Table

    recordings = "1 recording" if len(read.names) == 1 else f"{len(read.names)} recordings"
    grips = "1 grip" if found.grips == 1 else f"{found.grips} grips"
    click.echo(f"{grips} in {recordings}; today's values are those of {read.whose}")
    for name, number in found.set_aside.items():
        click.echo(
            f"{number} of them are not counted for {display_name(name)}: the readings do not show what was recorded."
        )
    table = Table("number", box=None, pad_edge=False)
    table.add_column("today's value", justify="right")
    for column in ("nothing changes", "grips today", "below that", "above that"):
        table.add_column(column)
    for each in (one for one in found.tried if one.changes):
        below = [(value, counts) for value, counts in reversed(each.values) if value < each.same_from]
        above = [(value, counts) for value, counts in each.values if value > each.same_to]
        table.add_row(
            _named(each), _number(each, each.parameter.today),
            f"{_end(each.same_from, each.ends_below)} to {_end(each.same_to, each.ends_above)}",
            str(each.today), *(_told(some, every=every) for some in (below, above)),
        )  # fmt: skip
    if table.row_count:
        print_table(table)
        click.echo("*: no farther value was tried, or makes sense alone.")
    if same := [each for each in found.tried if not each.changes]:
        click.echo("Nothing changes for any value that was tried:")
        for each in same:
            low, high = each.values[0][0], each.values[-1][0]
            counts = "" if str(each.today) == "none" else f": {each.today}"
            click.echo(f"  {_named(each)} {low:g} to {_number(each, high)}{counts}")
    click.echo("Not tried, because no recorded grip depends on it:")
    reasons: dict[str, list[str]] = {}
    for key, why in found.not_tried:
        reasons.setdefault(why, []).append(key.removeprefix("actuators."))
    for why, keys in reasons.items():
        click.echo(f"  {', '.join(keys)}: {why}")
    for note in read.notes:
        click.echo(f"Note: {note}", err=True)


def _named(each: Tried) -> str:
    """Return the key, and the part where the key is the same for all parts."""
    key, part = each.parameter.key, each.parameter.part
    of = f" ({part})" if part and not key.startswith("parts.") else ""
    return f"{key.removeprefix('actuators.')}{of}"


def _end(value: float, ends: bool) -> str:
    return f"{value:g}{'' if ends else '*'}"


def _number(each: Tried, value: float) -> str:
    return f"{value:g} {each.parameter.unit}".rstrip()


def _told(some: Sequence[tuple[float, object]], *, every: bool) -> str:
    """Return values and their results as text, such as ``54.1: 1 late … 72: 12 failed``.

    The text has the first, the middle and the last change; of equal consecutive results only the first is listed.
    """
    told: list[tuple[float, object]] = []
    for value, counts in some:
        if every or not told or told[-1][1] != counts:
            told.append((value, counts))
    if not every and len(told) > 3:
        told = [told[0], told[len(told) // 2], told[-1]]
    return " · ".join(f"{value:g}: {counts}" for value, counts in told)
