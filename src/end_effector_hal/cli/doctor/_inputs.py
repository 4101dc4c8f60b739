"""Checks the inputs of the board: whether their lines and devices exist, and which process uses them. Nothing is
requested.
"""

from __future__ import annotations

from pathlib import Path

from end_effector_hal.description import Channel, Description, Inputs, measures_of
from end_effector_hal.errors import WireError
from end_effector_hal.signals import Measure
from end_effector_hal.wires import holders_of

from ._check_result import CheckedPart, CheckResult, CheckResults
from ._lines import CHIPS, RESTART, look_for_lines

_say = CheckedPart("inputs")


def look_at_inputs(description: Description, chips: str = CHIPS) -> CheckResults:
    """Check the inputs of the board.

    Args:
        description: the description of the tool.
        chips: pattern of the paths of the character devices.
    """
    from end_effector_hal.wires.inputs import INPUT_CONSUMER, input_lines

    if not any(channel.on_board for channel in description.channels.values()):
        yield _say.ok("none: all channels come over the link")
    lines = tuple(input_lines(description))
    if lines and description.lines.backend == "virtual":
        yield _virtual(Path(description.lines.path or ""), lines)
    elif lines:
        yield from look_for_lines(_say, lines, chips, INPUT_CONSUMER, "the reader of the sensors")
    folder, measures = Path((description.inputs or Inputs()).iio), measures_of(description)
    for name, channel in description.channels.items():
        if channel.analog:
            yield _analog(name, channel, folder, measures[name])


def _virtual(path: Path, lines: tuple[str, ...]) -> CheckResult:
    from end_effector_hal.wires.lines import read_chip

    try:
        chip = read_chip(path)
    except WireError as error:
        return _say.missing(f"{path}: {error.what}", "Start eehal testbench, which makes it.")
    if absent := [name for name in lines if name not in chip.lines]:
        return _say.missing(f"{path} has no line {', '.join(absent)}", RESTART)
    holders = (each for reader in ("inputs", "arbiter") for each in holders_of(f"{path}.{reader}.lock"))
    held = " and ".join(map(str, holders))
    high = [name for name in lines if chip.lines[name].level]
    return _say.ok(f"virtual chip {path}; high: {', '.join(high) or 'none'}; read by {held or 'nobody'}")


def _analog(name: str, channel: Channel, folder: Path, measure: Measure) -> CheckResult:
    from end_effector_hal.wires.inputs import AnalogReader

    reader = AnalogReader(folder, {name: channel})
    value = reader.read(name)
    if name in reader.errors:
        return _say.missing(reader.errors[name].rstrip("."), "Is the converter wired, its driver loaded?")
    if value is None:
        return _say.warning(f"{name} shows what its sensor cannot mean", "Is a wire off, or the range wrong?")
    return _say.ok(f"{name}: {measure.text(value)}")
