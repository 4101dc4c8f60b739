"""Finds lines on the GPIO chips of this machine: by name, or by chip and offset. Reading claims nothing."""

from __future__ import annotations

import glob
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from end_effector_hal.errors import LineNotFoundError, WireError
from end_effector_hal.kinds.stanza import LineAddress
from end_effector_hal.vocabulary import hint
from end_effector_hal.wires.lines._backend import line_not_found

MOST_REQUESTED = 64
"""Most lines of one request: GPIO_V2_LINES_MAX of the kernel."""


class LinePlace(NamedTuple):
    """A line of a chip, and the kernel's information about it."""

    chip: str
    offset: int
    info: Any

    def __str__(self) -> str:
        return f"{self.chip} line {self.offset}"


class SeenChip(NamedTuple):
    """A chip: the path of its character device, its label, the kernel's information about each line by offset."""

    path: str
    label: str
    infos: tuple[Any, ...]

    def __str__(self) -> str:
        return f"{Path(self.path).name} [{self.label}], {len(self.infos)} lines"


def see_chip(gpiod: Any, path: str) -> SeenChip:
    """Read a chip; raises WireError."""
    with open_chip(gpiod, path) as chip:
        about = chip.get_info()
        return SeenChip(path, about.label, tuple(map(chip.get_line_info, range(about.num_lines))))


def places_of(line: str, chips: Sequence[SeenChip]) -> list[LinePlace]:
    """Return the places of a line; a good one has one."""
    address = LineAddress.of(line)
    if address is None:
        return [
            LinePlace(chip.path, offset, info)
            for chip in chips
            for offset, info in enumerate(chip.infos)
            if info.name == line
        ]
    return [
        LinePlace(chip.path, address.offset, chip.infos[address.offset])
        for chip in _called(address.chip, chips)
        if address.offset < len(chip.infos)
    ]


def _called(name: str, chips: Sequence[SeenChip]) -> list[SeenChip]:
    """Return the chips with this name or path, or else those with this label."""
    device = os.path.realpath(Path("/dev", name))
    named = [chip for chip in chips if device == chip.path or name == Path(chip.path).name]
    return named or [chip for chip in chips if chip.label == name]


def missing_line(line: str, chips: Sequence[SeenChip]) -> str:
    """Return the text of a line that no chip has, with what there is instead."""
    address = LineAddress.of(line)
    if address is None:
        return line + hint(line, [info.name for chip in chips for info in chip.infos])
    found = _called(address.chip, chips)
    reason = f"no chip {address.chip}" if not found else f"no offset {address.offset}"
    return f"{line} ({reason}; there is {'; '.join(map(str, found or chips))})"


def find_lines(
    gpiod: Any, pattern: str, names: Sequence[str], beside: Sequence[str] = ()
) -> dict[str, tuple[str, int]]:
    """Return chip and offset of each line; other boards have the same names on other chips.

    Args:
        gpiod: the module.
        pattern: glob pattern of the chips.
        names: the lines, as their texts.
        beside: other lines of the tool, which must not be one of these; those that do not exist are ignored.

    Raises:
        LineNotFoundError: a line is missing or ambiguous.
        WireError: there is no chip, it cannot be opened, or one line is described twice.
    """
    chips = [see_chip(gpiod, path) for path in find_chips(gpiod, pattern)]
    places = {name: places_of(name, chips) for name in names}
    if missing := [missing_line(name, chips) for name, found in places.items() if not found]:
        raise line_not_found(missing, looked_at=[chip.path for chip in chips])
    for name, found in places.items():
        if len(found) > 1:
            raise LineNotFoundError(f"the line {ambiguous(name, found)}.", todo=UNIQUE)
    others = {name: places_of(name, chips) for name in beside if name not in places}
    for name, (other, place) in shared_lines({**places, **others}).items():
        raise WireError(
            f"{other} and {name} are one line: {place}.",
            todo="Give each device a line of its own in the description.",
        )
    return {name: found[0][:2] for name, found in places.items()}


UNIQUE = "Give the lines unique names in the device tree, or write chip and offset: docs/how-to/wiring.md."


def ambiguous(line: str, places: Sequence[LinePlace]) -> str:
    """Return a clause that says where the lines of one name are."""
    return f"{line} is ambiguous: {' and '.join(map(str, places))}"


def shared_lines(places: Mapping[str, Sequence[LinePlace]]) -> dict[str, tuple[str, str]]:
    """Return the name of the earlier line, and their place, by the name of each line that is the same as another."""
    first: dict[str, str] = {}
    shared: dict[str, tuple[str, str]] = {}
    for name, found in places.items():
        for place in map(str, found):
            if (other := first.setdefault(place, name)) != name:
                shared[name] = other, place
    return shared


def chip_requests(found: Mapping[str, tuple[str, int]]) -> list[tuple[str, dict[str, int]]]:
    """Return the chip of each request, and its offsets by name: the lines of one chip, up to the kernel's limit."""
    requests: list[tuple[str, dict[str, int]]] = []
    open_for: dict[str, dict[str, int]] = {}
    for name, (chip, offset) in found.items():
        if len(open_for.get(chip, {})) in (0, MOST_REQUESTED):
            open_for[chip] = {}
            requests.append((chip, open_for[chip]))
        open_for[chip][name] = offset
    return requests


def find_chips(gpiod: Any, pattern: str) -> list[str]:
    """Return the character devices of GPIO chips; raises WireError if there is none."""
    paths = sorted({str(Path(path).resolve()) for path in glob.glob(pattern)})
    chips = [path for path in paths if gpiod.is_gpiochip_device(path)]
    if not chips:
        raise WireError(
            f"there is no GPIO chip on this machine ({pattern} matches none).",
            todo="The kernel needs CONFIG_GPIO_CDEV and a driver; a container needs "
            "--device /dev/gpiochip0. Without hardware use the virtual back-end.",
        )
    return chips


def open_chip(gpiod: Any, path: str) -> Any:
    """Open a chip, for use in a ``with`` block; raises WireError."""
    try:
        return gpiod.Chip(path)
    except PermissionError as error:
        raise WireError(
            "the GPIO chip cannot be opened: permission denied.",
            where=path,
            todo="Add the user to the group gpio (gid 49 on Torizon) and log in again; "
            "a container needs --group-add 49.",
        ) from error
    except OSError as error:
        raise WireError(
            f"the GPIO chip cannot be opened: {error.strerror}.", where=path, todo="see dmesg."
        ) from error
