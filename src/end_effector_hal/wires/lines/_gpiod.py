"""The ``gpiod`` line back-end: real lines (libgpiod's v2 API, PyPI ``gpiod``)."""

from __future__ import annotations

import errno
import importlib
import os
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

from end_effector_hal.errors import LineBusyError, WireError
from end_effector_hal.wires._claim import holders_of_lines
from end_effector_hal.wires.lines._backend import wire_errors
from end_effector_hal.wires.lines._chips import chip_requests, find_lines, open_chip

CONSUMER = "end-effector-hal"


class GpiodLines:
    """A `LineBackend` on ``/dev/gpiochip*``; one request for up to 64 lines of a chip.

    Args:
        pattern: glob pattern of the chips.
        inputs: input lines of the same tool; a line that is one of them is refused.
    """

    def __init__(self, pattern: str = "/dev/gpiochip*", *, inputs: Sequence[str] = ()) -> None:
        self._pattern, self._inputs = pattern, inputs
        self._requests: list[tuple[Any, dict[str, int]]] = []
        self._names: list[str] = []
        self._stored: dict[str, int] = {}

    def restore(self, descriptors: Mapping[str, int]) -> None:
        """Use stored requests; see `LineHandover`."""
        self._stored = dict(descriptors)

    def descriptors(self) -> dict[str, int]:
        """Return the descriptor of each request, named by its chip and its lines in order; see `LineHandover`."""
        return {name: request.fd for name, (request, _) in zip(self._names, self._requests, strict=True)}

    def request(self, names: Sequence[str]) -> dict[str, bool]:
        """Claim and adopt the lines; see `LineBackend.request`."""
        self._gpiod = load_gpiod()
        wanted = chip_requests(find_lines(self._gpiod, self._pattern, names, self._inputs))
        self._names = [_stored_name(chip, offsets) for chip, offsets in wanted]
        for name in set(self._stored).difference(self._names):
            os.close(self._stored.pop(name))  # of another description: first given back, or they are busy
        try:
            for name, (chip, offsets) in zip(self._names, wanted, strict=True):
                self._requests.append((self._claimed(name, chip, offsets), offsets))
        except BaseException:
            self.close()
            raise
        return self.levels()

    def levels(self) -> dict[str, bool]:
        """Return the levels of the claimed lines, read back from the kernel."""
        active = self._gpiod.line.Value.ACTIVE
        levels: dict[str, bool] = {}
        for request, offsets in self._requests:
            with self._working():
                values = request.get_values(list(offsets.values()))
            levels |= {name: value == active for name, value in zip(offsets, values, strict=True)}
        return levels

    def set(self, levels: Mapping[str, bool]) -> None:
        """Write some of the claimed lines; the lines of one request are written at once."""
        for request, offsets in self._requests:
            values = {offsets[name]: self._value(level) for name, level in levels.items() if name in offsets}
            if values:
                with self._working():
                    request.set_values(values)

    def close(self) -> None:
        """Release the lines; the kernel's driver decides whether they keep their levels (gpio-mxc keeps them)."""
        self._names = []
        while self._requests:
            self._requests.pop()[0].release()

    def _working(self) -> AbstractContextManager[None]:
        todo = "The GPIO chip has gone, or its driver fails: see dmesg."
        return wire_errors("the lines do not work any more", self._pattern, todo)

    def _value(self, level: bool) -> Any:
        value = self._gpiod.line.Value
        return value.ACTIVE if level else value.INACTIVE

    def _claimed(self, name: str, chip: str, offsets: Mapping[str, int]) -> Any:
        if name in self._stored:
            from end_effector_hal.wires.lines._held_request import HeldRequest  # on Linux only

            return HeldRequest(self._stored.pop(name), list(offsets.values()), self._gpiod.line.Value)
        return self._adopt(chip, offsets)

    def _adopt(self, path: str, offsets: Mapping[str, int]) -> Any:
        """Claim the lines as they are, read their directions and levels, then make all of them outputs with these
        levels.

        One request is used throughout. If it were released in between, some controllers would drop the level, and
        another program could claim the lines. `reconfigure_lines` resets lines that it does not name; here it names
        every line.
        """
        line, settings = self._gpiod.line, self._gpiod.LineSettings
        with open_chip(self._gpiod, path) as chip:
            request = None
            try:
                as_is = {tuple(offsets.values()): settings(direction=line.Direction.AS_IS)}
                request = chip.request_lines(config=as_is, consumer=CONSUMER)
                levels = request.get_values(list(offsets.values()))
                kept = {
                    offset: level == line.Value.ACTIVE
                    and chip.get_line_info(offset).direction == line.Direction.OUTPUT
                    for offset, level in zip(offsets.values(), levels, strict=True)
                }
                request.reconfigure_lines(
                    {
                        offset: settings(direction=line.Direction.OUTPUT, output_value=self._value(level))
                        for offset, level in kept.items()
                    }
                )
            except OSError as error:
                if request is not None:
                    request.release()
                if error.errno == errno.EBUSY:
                    raise busy(chip, path, offsets) from error
                raise WireError(
                    f"the lines cannot be claimed: {error.strerror}.",
                    where=path,
                    todo="`gpioinfo` shows who holds them; `eehal doctor --only lines` checks them.",
                ) from error
            return request


def _stored_name(chip: str, offsets: Mapping[str, int]) -> str:
    return ".".join([Path(chip).name, *map(str, offsets.values())])


def busy(chip: Any, path: str, offsets: Mapping[str, int]) -> LineBusyError:
    """Return an error that names the busy lines of a chip and their holders."""
    infos = {name: chip.get_line_info(offset) for name, offset in offsets.items()}
    held = [f"{name} is held by {info.consumer or 'the kernel'}" for name, info in infos.items() if info.used]
    text = ", ".join(held) or "a line is held by another program"
    return LineBusyError(f"{text}.", where=path, todo=stop_holders())


def load_gpiod() -> Any:
    """Import and return the module, on demand; Debian's ``python3-libgpiod`` 1.6 has the same name and another API."""
    try:
        gpiod = importlib.import_module("gpiod")
    except ImportError as error:
        raise WireError(f"gpiod cannot be imported: {error}.", todo="pip install 'gpiod>=2.1,<3'.") from error
    version = str(getattr(gpiod, "api_version", "1"))
    if not version.startswith("2."):
        raise WireError(
            f"gpiod has the API {version}, needed is 2.",
            todo="pip install 'gpiod>=2.1,<3' into this environment.",
        )
    return gpiod


def stop_holders(proc: str = "/proc") -> str:
    """Return advice about a busy line. The kernel reports a name that the holder chose; /proc shows all processes with
    lines.
    """
    found = holders_of_lines(proc)
    if not found:
        return "Stop the program that holds it."
    holds = "hold" if len(found) > 1 else "holds"
    return f"Stop the program that holds it; {' and '.join(map(str, found))} {holds} lines."
