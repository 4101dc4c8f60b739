"""Checks the output lines and the inputs of the board: whether they exist, and which process uses them.

Nothing is requested, since a request would move lines.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from end_effector_hal.description import Channel, Description, Inputs, did_you_mean, measures_of
from end_effector_hal.errors import WireError
from end_effector_hal.signals import Measure
from end_effector_hal.wires import holders_of

from ._check_result import CheckedPart, CheckResult, CheckResults

if TYPE_CHECKING:
    from end_effector_hal.wires.lines import LinePlace, SeenChip

CHIPS = "/dev/gpiochip*"
RESTART = "Make it again: `eehal testbench DESCRIPTION --power-cycle`."
_say = CheckedPart("lines")


def look_at_lines(description: Description, lines: tuple[str, ...], chips: str = CHIPS) -> CheckResults:
    """Check the output lines.

    Args:
        lines: all output lines of the tool.
        chips: pattern of the paths of the character devices.
    """
    from end_effector_hal.wires.lines import CONSUMER

    if description.lines.backend == "virtual":
        yield _virtual(description, lines)
    else:
        yield from look_for_lines(_say, lines, chips, CONSUMER, "the line arbiter")


def _virtual(description: Description, lines: tuple[str, ...]) -> CheckResult:
    from end_effector_hal.wires.lines import read_chip

    path = description.lines.path
    if path is None:
        return _say.missing("virtual lines without a file", "Add path: to lines in the description.")
    try:
        chip = read_chip(path)
    except WireError as error:
        return _say.missing(f"{path}: {error.what}", "Start eehal testbench, which makes it.")
    absent = [name for name in lines if name not in chip.lines]
    if absent:
        return _say.missing(f"{path} has no line {_named(absent, list(chip.lines))}", RESTART)
    held = " and ".join(map(str, holders_of(f"{path}.lock")))
    active = [name for name in lines if chip.lines[name] == ("out", True)]
    text = f"virtual chip {path}; active: {', '.join(active) or 'none'}; held by {held or 'nobody'}"
    others = [name for name, line in chip.lines.items() if line == ("out", True) and name not in lines]
    if others:
        text = f"{text}; active, and no line of this description: {', '.join(others)}"
        return _say.missing(text, "Drop with the description that drives it before you use this one.")
    if not os.access(path, os.W_OK):
        return _say.missing(f"{text}; it may not be written", "Run as the user who made it.")
    return _say.ok(text)


def look_for_lines(
    say: CheckedPart, lines: tuple[str, ...], pattern: str, consumer: str, who: str
) -> CheckResults:
    """Check lines of real chips; ``consumer`` is the kernel's name of the program that may hold them, ``who`` its name
    for people.
    """
    from end_effector_hal.wires import lines as gpio

    try:
        gpiod = gpio.load_gpiod()
        chips = gpio.find_chips(gpiod, pattern)
    except WireError as error:
        yield say.missing(error.what.rstrip("."), error.todo)
        return
    seen: list[SeenChip] = []
    for path in chips:
        try:
            seen.append(gpio.see_chip(gpiod, path))
        except WireError as error:
            yield say.missing(f"{path}: {error.what.rstrip('.')}", error.todo)
    places = {name: gpio.places_of(name, seen) for name in lines}
    if absent := [gpio.missing_line(name, seen) for name, found in places.items() if not found]:
        yield say.missing(
            f"no line {', '.join(absent)} on {', '.join(chips)}",
            "gpioinfo lists the names; put yours into the description, or chip and offset.",
        )
    shared = gpio.shared_lines({name: found for name, found in places.items() if len(found) == 1})
    for name, found in places.items():
        if len(found) > 1:
            yield say.missing(gpio.ambiguous(name, found), gpio.UNIQUE)
        elif name in shared:
            other, place = shared[name]
            yield say.missing(f"{other} and {name} are one line: {place}", "Give each device its own line.")
        elif found:
            yield _line(say, name, found[0], consumer, who)


def _line(say: CheckedPart, name: str, where: LinePlace, consumer: str, who: str) -> CheckResult:
    info = where.info
    direction = str(info.direction).rpartition(".")[2].lower()
    if not info.used:
        return say.ok(f"{name} = {where}, {direction}, free")
    if info.consumer == consumer:
        return say.ok(f"{name} = {where}, {direction}, held by {who}")
    return say.missing(
        f"{name} = {where} is held by {info.consumer or 'the kernel'}", "Stop the program that holds it."
    )


def _named(absent: list[str], known: list[str]) -> str:
    hints = [(name, did_you_mean(name, known)) for name in absent]
    return ", ".join(f"{name} ({hint})" if hint else name for name, hint in hints)


_of_inputs = CheckedPart("inputs")


def look_at_inputs(description: Description, chips: str = CHIPS) -> CheckResults:
    """Check the inputs of the board.

    Args:
        chips: pattern of the paths of the character devices.
    """
    from end_effector_hal.wires.inputs import INPUT_CONSUMER, input_lines

    if not any(channel.on_board for channel in description.channels.values()):
        yield _of_inputs.ok("none: all channels come over the link")
    lines = tuple(input_lines(description))
    if lines and description.lines.backend == "virtual":
        yield _virtual_inputs(Path(description.lines.path or ""), lines)
    elif lines:
        yield from look_for_lines(_of_inputs, lines, chips, INPUT_CONSUMER, "the reader of the sensors")
    folder, measures = Path((description.inputs or Inputs()).iio), measures_of(description)
    for name, channel in description.channels.items():
        if channel.analog:
            yield _analog(name, channel, folder, measures[name])


def _virtual_inputs(path: Path, lines: tuple[str, ...]) -> CheckResult:
    from end_effector_hal.wires.lines import read_chip

    try:
        chip = read_chip(path)
    except WireError as error:
        return _of_inputs.missing(f"{path}: {error.what}", "Start eehal testbench, which makes it.")
    if absent := [name for name in lines if name not in chip.lines]:
        return _of_inputs.missing(f"{path} has no line {', '.join(absent)}", RESTART)
    holders = (each for reader in ("inputs", "arbiter") for each in holders_of(f"{path}.{reader}.lock"))
    held = " and ".join(map(str, holders))
    high = [name for name in lines if chip.lines[name].level]
    return _of_inputs.ok(
        f"virtual chip {path}; high: {', '.join(high) or 'none'}; read by {held or 'nobody'}"
    )


def _analog(name: str, channel: Channel, folder: Path, measure: Measure) -> CheckResult:
    from end_effector_hal.wires.inputs import AnalogReader

    reader = AnalogReader(folder, {name: channel})
    value = reader.read(name)
    if name in reader.errors:
        return _of_inputs.missing(
            reader.errors[name].rstrip("."), "Is the converter wired, its driver loaded?"
        )
    if value is None:
        return _of_inputs.warning(
            f"{name} shows what its sensor cannot mean", "Is a wire off, or the range wrong?"
        )
    return _of_inputs.ok(f"{name}: {measure.text(value)}")
