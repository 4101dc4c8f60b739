"""``eehal check``: prints all faults of a description, or a summary if it has none."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from end_effector_hal.description import (
    CONFIRMED,
    Description,
    Fault,
    GrippedPart,
    examine,
    load,
    measures_of,
    profile_path,
    socket_path,
    used_channels,
)
from end_effector_hal.errors import ArbiterError, Diagnostic, LineBusyError, ReportedError
from end_effector_hal.kinds import kind_of

from ._excerpt import MarkedFault, marked
from ._options import PathName
from ._output import print_document

if TYPE_CHECKING:
    from rich.table import Table


BAD_DESCRIPTION = 2


@click.command(name="check")
@click.argument("file", type=PathName(), required=False)
@click.option(
    "--instead-of",
    metavar="RUNNING",
    type=PathName(),
    help="Also refuse while the tool of this description runs with an active line: exit code 3.",
)
@click.option("--json", "as_json", is_flag=True, help="Print {ok, exit_code, faults, ...} as JSON.")
def command(file: Path | None, instead_of: Path | None, as_json: bool) -> None:
    """Check a description, its codec and its automata; FILE defaults to the shipped one.

    Every fault is a line on stderr, file:line:column: offending text, expected …; hint [code]. Below it the line of
    the file is printed with the offending text marked. The exit code is then 2. Without faults the command prints a
    summary, the computed bounds, the signals that the link does not carry, and the times for which the link is too
    slow.
    """
    checked = check(file or profile_path())
    if instead_of is not None and not checked.faults:
        _refuse_while_active(load(instead_of))
    if as_json:
        print_document(checked.as_json())
    for each in checked.found if not as_json else ():
        click.echo(str(each.diagnostic), err=True)
        for line in each.excerpt():
            click.echo(line, err=True)
    if checked.faults or checked.description is None:
        sys.exit(BAD_DESCRIPTION)
    if not as_json:
        _print_summary(checked.description, checked)


def _refuse_while_active(running: Description) -> None:
    """Raise an error if a line of the running tool is active: a held part would be adopted by other automata. Without
    a running line arbiter nothing is checked.
    """
    from end_effector_hal.arbiter import ArbiterClient, arbiter_policy

    path = socket_path(running)
    try:
        with ArbiterClient(path, "check", patience_s=0) as client:
            levels, status = client.levels(), client.status()
    except ArbiterError as error:
        if isinstance(error.__cause__, (FileNotFoundError, ConnectionRefusedError)):
            return
        raise
    active = [arbiter_policy(running).called(line) for line, level in levels.items() if level]
    unknown = [line for line in status["may_be_active"] if not levels.get(line)]
    active += [f"{line} (its level is unknown)" for line in unknown]
    if active:
        raise LineBusyError(
            f"{running.name} runs with active lines, a part may be held: {', '.join(active)}.",
            where=str(path),
            todo="Drop it first; nothing has changed.",
        )


@dataclass(frozen=True)
class Checked:
    """The result of checking a description.

    Attributes:
        description: the description; None if its keys or values are faulty.
        found: every fault, with its line of the file.
        not_fitted, slow, hints: sentences about a description without faults.
    """

    description: Description | None
    found: tuple[MarkedFault, ...]
    not_fitted: tuple[str, ...] = ()
    slow: tuple[str, ...] = ()
    hints: tuple[str, ...] = ()

    @property
    def faults(self) -> tuple[Diagnostic, ...]:
        """The faults without the lines of the file."""
        return tuple(each.diagnostic for each in self.found)

    def as_json(self) -> dict[str, object]:
        """Return the object for ``--json``."""
        return {
            "ok": not self.faults,
            "exit_code": BAD_DESCRIPTION if self.faults else 0,
            "faults": [fault.as_json() for fault in self.faults],
            "not_fitted": list(self.not_fitted),
            "warnings": list(self.slow),
            "hints": list(self.hints),
            "devices": [] if self.description is None else _devices(self.description),
            "computed_bounds": computed_bounds(self.description) if self.description is not None else {},
        }


def computed_bounds(description: Description) -> dict[str, float]:
    """Return the bounds that the description does not contain and that are computed, in seconds by their key."""
    durations = description.durations
    return {key: durations.seconds(key) for key in durations.computed}


def _devices(description: Description) -> list[dict[str, object]]:
    """Return the devices that the actuators use, with the keys that the description writes itself."""
    return [
        {
            "actuator": name,
            "device": each.name,
            "title": each.title,
            "file": str(each.file),
            "confirmed": each.confirmed,
            "channels": list(each.channels),
            "written_here": list(each.overridden),
        }
        for name, each in description.used_devices.items()
    ]


def check(path: Path) -> Checked:
    """Check a description with its codec and its automata; return all faults at once.

    If a part is faulty, the others are checked nevertheless: defaults replace the faulty values, and faults that only
    follow from others are left out.
    """
    examination = examine(path)
    faults, likely = list(examination.faults), examination.likely
    match, automata = None, tuple[Diagnostic, ...]()
    codecs = [(*likely.link_path(name), "codec") for name in likely.links] if likely is not None else []
    broken = any(examination.is_broken(*each) for each in (*codecs, ("link", "codec")))
    if likely is not None and not broken and all(_carries(likely, each) for each in likely.links):
        from end_effector_hal.codecs import match_codec
        from end_effector_hal.nodes.interface import name_faults

        faulty = {
            str(each.path[1]) for each in faults if each.path[:1] == ("channels",) and len(each.path) > 1
        }
        match = match_codec(likely, faulty)
        further: list[Fault] = sorted((*match.faults, *name_faults(likely)))
        faults += [each for each in further if not examination.is_broken(*each.path)]
        # without a codec nothing is put together
        without_codec = any(each.code == "EE-226" for each in match.faults)
        if not without_codec and not examination.is_broken("automata"):
            automata = _automata_faults(likely)
    description = examination.description
    found = [marked(each, examination.name, examination.text) for each in sorted(set(faults))]
    found += [MarkedFault(each) for each in automata]
    if description is None or match is None:
        return Checked(description, tuple(found))
    return Checked(description, tuple(found), match.not_fitted, match.slow, tuple(_hints(description)))


def _carries(likely: Description, name: str) -> bool:
    """Return whether the link still carries a channel: its frame, or every one of its channels, may be faulty."""
    frame = likely.links[name].frame
    return frame is None or any(
        channel.source == frame.format for channel in likely.channels_over(name).values() if frame.format
    )


MODICON = {1: "discrete_input", 3: "input", 4: "holding"}
"""The Modbus table that the first digit of a five-digit register number stands for."""


def _hints(description: Description) -> Iterator[str]:
    """Yield a sentence for every value that is valid but probably not intended."""
    for name, channel in description.channels.items():
        place = channel.modbus
        written = description.place("channels", name, "modbus", "address").text.lower()
        if place is None or not written.isdecimal():  # a manual counts 40001 in decimal digits
            continue
        if (table := MODICON.get(place.address // 10_000)) and place.address % 10_000 > 0:
            yield (
                f"{description.where('channels', name, 'modbus', 'address')}: is {place.address} the number in a "
                f"manual? On the wire that is address: {place.address % 10_000 - 1}, register_type: {table}"
            )
    for name, link in description.links.items():
        if link.frame and not link.frame.checked:
            yield (
                f"{description.where(*description.link_path(name), 'frame')}: without a checksum a digit that is lost "
                "on the way is a reading like any other; declare it where the device can send one, or let "
                "conditions hold for some time (for_ms, samples)"
            )
    for name, actuator in description.ordered:
        measure = measures_of(description).get(actuator.channel)
        if actuator.evidence is None and measure and measure.decimals > 1:
            yield (
                f"{description.where('actuators', name)}: {name} has a threshold finer than 0.1 kPa, and "
                "alarms and the page show no more decimals than that; `eehal listen` shows all of them"
            )
    used = {*used_channels(description), *(name for name, each in description.channels.items() if each.alarm)}
    for output in description.register_outputs.values():  # what a commanded device reports of itself
        used |= {output.verify or "", output.activation.ready if output.activation else ""}
        used |= {output.handshake.taken} if output.handshake else set[str]()
    for name in [each for each in description.channels if each not in used]:
        yield f"{description.where('channels', name)}: nothing uses the channel {name}"


def _automata_faults(description: Description) -> tuple[Diagnostic, ...]:
    from end_effector_hal.control import load_automata

    try:
        load_automata(description)
    except ReportedError as error:
        return error.diagnostics
    return ()


def _print_summary(description: Description, checked: Checked) -> None:
    from rich.console import Console

    # No markup: names and summaries are the user's.
    console = Console(highlight=False, markup=False, emoji=False, soft_wrap=True)
    console.print(description.name, style="bold", end="  ")
    console.print(f"{description.summary} ({description.fingerprint()})")
    console.print(_actuators(description), soft_wrap=False)
    for line in _rest(description):
        console.print(line)
    if computed := computed_bounds(description):
        said = ", ".join(f"{key} = {seconds:g}" for key, seconds in computed.items())
        console.print(f"bounds    computed from times and attempts, for lack of `bounds:`: {said}")
    switched_off = [key for key, on in description.interlocks.model_dump(by_alias=True).items() if not on]
    if switched_off:
        console.print(f"switched off  {', '.join(switched_off)}", style="bold yellow")
    for sentence in checked.not_fitted:
        console.print(f"not fitted  {sentence}", style="yellow")
    for sentence in checked.slow:
        console.print(f"warning  {sentence}", style="bold yellow")
    for sentence in checked.hints:
        console.print(f"hint  {sentence}")


def _actuators(description: Description) -> Table:
    """Return a table of the actuators in the order of a grip."""
    from rich.table import Table

    columns = ("actuator", "kind", "line", "pin", "channel", "time-out", "reset", "release")
    table = Table(*columns, box=None, pad_edge=False, padding=(0, 1))
    for name, each in description.ordered:
        times = (f"{each.attempts} x {each.timeout_s:g} s", f"{each.reset_s:g} s", f"{each.release_s:g} s")
        table.add_row(name, each.kind, each.line, each.pin, each.channel, *times)
        if coil := each.opposite:
            table.add_row("", "second coil", coil.line, coil.pin)
        if each.modbus and each.modbus.opposite:
            table.add_row("", "second coil", each.modbus.second_coil)
        if blow_off := kind_of(each).opposing_output(each):
            table.add_row("", kind_of(each).opposing.replace("_", "-"), blow_off.line, blow_off.pin)
    return table


def _of_part(description: Description, name: str, stanza: GrippedPart) -> Iterator[str]:
    """Yield the actuators that grip a part, each with its own keys for it."""
    for each, used in zip(description.sequence, description.uses(name), strict=True):
        if used:
            keys = f" ({', '.join(stanza.actuators[each])})" if each in stanza.actuators else ""
            yield f"{each}{keys}"


def _rest(description: Description) -> Iterator[str]:
    """Yield one line for the tool changer and one for every wire."""
    from end_effector_hal.codecs import board_inputs, codec_of, line_words

    lines = description.lines
    if changer := description.tool_changer:
        pin = f", {changer.pin}" if changer.pin else ""
        proof = f"{changer.locked_bit} or {changer.unlocked_bit} within {changer.prove_s:g} s"
        at_most = "latching" if changer.latching else f"unlock at most {changer.unlock_max_s:g} s"
        locks = f"; {changer.opposite.line} locks" if changer.opposite else ""
        yield f"changer   {changer.line}{pin}{locks}; {proof}; {at_most}"
    yield f"lines     {lines.backend}" + (f", {lines.path}" if lines.path else "")
    for name, link in description.links.items():
        codec = codec_of(description, name)
        called, line = f"{name}: " if name else "", line_words(link, codec)
        yield f"link      {called}{link.port}, {codec.name}{line and f', {line}'}"
    for name, stanza in description.parts.items():
        yield f"part      {name}: {', '.join(_of_part(description, name, stanza))}"
    if inputs := board_inputs(description):
        yield f"inputs    {', '.join(inputs.channels)}, each {inputs.period_us / 1000:g} ms"
    for name, device in description.used_devices.items():
        own = f"; written here: {', '.join(device.overridden)}" if device.overridden else ""
        confirmed = CONFIRMED[device.confirmed]
        yield f"device    {name}: {device.name}, {device.title} ({device.file}), confirmed {confirmed}{own}"
    yield f"automata  {description.automata_path}"
