"""``eehal check``: everything that is wrong with a description, or what it says in short."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from end_effector_hal.description import (
    Carried,
    Description,
    Fault,
    did_you_mean,
    examine,
    not_fitted,
    profile_path,
    unproven,
)
from end_effector_hal.errors import EndEffectorError

if TYPE_CHECKING:
    from rich.table import Table

Finding = tuple[str, dict[str, object]]


@click.command(name="check")
@click.argument("file", type=click.Path(path_type=Path), required=False)
@click.option("--json", "as_json", is_flag=True, help="Print {ok, faults, not_fitted} as JSON.")
def command(file: Path | None, as_json: bool) -> None:
    """Check a description, its codec and its automata; FILE defaults to the shipped one.

    Every fault is a line on stderr, file:line:column: what (offending text), expected …; hint [code], and the
    exit code is 2. Without faults: a summary, and what the link does not carry.
    """
    path = file or profile_path()
    examination = examine(path)
    description = examination.description
    findings = [_finding(str(path), fault) for fault in examination.faults]
    absent: list[str] = []
    if description is not None:
        findings, absent = _against_the_rest(description, str(path))
    if as_json:
        faults = [found for _, found in findings]
        document = {"ok": not faults, "faults": faults, "not_fitted": absent}
        click.echo(json.dumps(document, indent=2))
    else:
        for line, _ in findings:
            click.echo(line, err=True)
    if findings or description is None:
        sys.exit(2)
    if not as_json:
        _print_summary(description, absent)


def _against_the_rest(description: Description, name: str) -> tuple[list[Finding], list[str]]:
    """What only shows together with the codec and the automata: faults, and what is not fitted."""
    from end_effector_hal.control import shows_noise
    from end_effector_hal.wires import codec_names, get_codec

    wanted, known = description.link.codec, codec_names()
    try:
        codec = get_codec(wanted)
    except EndEffectorError as error:
        what = error.what.rstrip(".") if wanted in known else "there is no such codec"
        place, hint = description.place("link", "codec"), did_you_mean(wanted, known)
        fault = Fault.at(place, "EE-226", what, expected=f"one of {', '.join(known)}", hint=hint)
        return [_finding(name, fault)], []
    channels = {key: kind.value for key, kind in codec.channels.items()}
    carried = Carried(codec.name, channels, codec.period_us, shows_noise(codec))
    faults = [_finding(name, fault) for fault in unproven(description, carried)]
    return [*faults, *_automata(description)], not_fitted(description, carried)


def _automata(description: Description) -> Iterator[Finding]:
    """A UPPAAL file that cannot be read, or does not fit the description: both programs are put together."""
    from end_effector_hal.automata import load_network
    from end_effector_hal.control import PROGRAMS, Controller, model_constants

    try:
        network = load_network(description.automata_path, model_constants(description))
        for program in PROGRAMS if description.tool_changer else PROGRAMS[:1]:
            Controller(description, network, program)
    except EndEffectorError as error:
        named = "automata" in description.model_fields_set
        where = str(error.where) or (
            description.where("automata") if named else str(description.automata_path)
        )
        file, line, column = _split(where)
        message = " ".join(f"{error.what} {error.todo}".removeprefix(where).split())
        found = {"code": error.code, "file": file, "line": line, "column": column, "message": message}
        yield f"{where}: {message} [{error.code}]", found


def _split(where: str) -> tuple[str, int, int]:
    """File, line and column of ``file:line:column``; 0 for what is not in it."""
    file, *numbers = where.rsplit(":", 2)
    if len(numbers) == 2 and all(each.isdigit() for each in numbers):
        return file, int(numbers[0]), int(numbers[1])
    return where, 0, 0


def _finding(name: str, fault: Fault) -> Finding:
    found = {
        "code": fault.code,
        "file": name,
        "line": fault.line,
        "column": fault.column,
        "message": fault.message,
    }
    return fault.render(name), found


def _print_summary(description: Description, absent: list[str]) -> None:
    from rich.console import Console

    # No markup: names and summaries are the user's.
    console = Console(highlight=False, markup=False, emoji=False, soft_wrap=True)
    console.print(description.name, style="bold", end="  ")
    console.print(f"{description.summary} ({description.fingerprint()})")
    console.print(_actuators(description), soft_wrap=False)
    for line in _rest(description):
        console.print(line)
    switched_off = [key for key, on in description.interlocks.model_dump(by_alias=True).items() if not on]
    if switched_off:
        console.print(f"switched off  {', '.join(switched_off)}", style="bold yellow")
    for sentence in absent:
        console.print(f"not fitted  {sentence}", style="yellow")


def _actuators(description: Description) -> Table:
    """In the order of a grip."""
    from rich.table import Table

    columns = ("actuator", "kind", "line", "pin", "channel", "time-out", "reset", "gone")
    table = Table(*columns, box=None, pad_edge=False, padding=(0, 1))
    for name, each in description.ordered:
        times = (f"{each.attempts} x {each.timeout_s:g} s", f"{each.reset_s:g} s", f"{each.release_s:g} s")
        table.add_row(name, each.kind, each.line, each.pin, each.channel, *times)
    return table


def _rest(description: Description) -> Iterator[str]:
    """Tool changer and wires, a line each."""
    link, lines = description.link, description.lines
    if changer := description.tool_changer:
        pin = f", {changer.pin}" if changer.pin else ""
        proof = f"{changer.locked_bit} or {changer.unlocked_bit} within {changer.prove_s:g} s"
        at_most = "latching" if changer.latching else f"unlock at most {changer.unlock_max_s:g} s"
        yield f"changer   {changer.line}{pin}; {proof}; {at_most}"
    yield f"lines     {lines.backend}" + (f", {lines.path}" if lines.path else "")
    baud = f"{link.baudrate} baud" if link.baudrate else "the baud rate of its codec"
    yield f"link      {link.port}, {link.codec}, {baud}"
    yield f"automata  {description.automata_path}"
