"""Simulates sensors on the inputs of a board: the levels of a virtual chip, and the files of analog devices."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from end_effector_hal.codecs import board_inputs
from end_effector_hal.description import Channel, Description, Inputs
from end_effector_hal.errors import WireError
from end_effector_hal.signals import Value
from end_effector_hal.wires.inputs import find_device, input_lines, pulls_of
from end_effector_hal.wires.lines import VirtualPins

from ._sensor_board import carried

SCALE_MV = 0.0625
"""Scale of an ADS1115 after power-up, mV per count."""
LONGEST_PERIOD_US = 5_000
"""Longest update period, µs; so short that edges of switches, which have no period of their own, come between two
readings.
"""


class BoardSensors:
    """Drives input lines and writes analog files, only for changed values.

    For an invalid sensor the line goes to its pull, and the file is removed; while all sensors are silent, lines keep
    their levels, and the files are removed.

    Args:
        chip: path of its virtual chip.
    """

    def __init__(self, description: Description, chip: str | Path) -> None:
        self._description = description
        self._channels = {name: each for name, each in description.channels.items() if each.on_board}
        self._kinds = {name: each.kind for name, each in self._channels.items()}
        self._pins = VirtualPins(chip)
        self._pulls = pulls_of(input_lines(description))
        self._iio = Path((description.inputs or Inputs()).iio)
        self._devices: dict[str, Path] = {}
        self._levels: dict[str, bool] = {}
        self._counts: dict[Path, int | None] = {}
        inputs = board_inputs(description)
        self.period_us = min(LONGEST_PERIOD_US, inputs.period_us if inputs else LONGEST_PERIOD_US)

    def start(self) -> None:
        """Create the missing devices; raises WireError if that fails."""
        for each in self._channels.values():
            if each.analog:
                try:
                    self._devices[each.analog.device] = device = self._device(each.analog.device)
                    (device / f"in_{each.analog.channel}_scale").write_text(f"{SCALE_MV}\n", encoding="ascii")
                except OSError as error:
                    where = str(error.filename or self._iio)
                    raise WireError(f"cannot be made: {error.strerror}.", where=where) from error

    def play(self, values: Mapping[str, Value], *, silent: bool) -> None:
        """Output the values of the sensors; raises WireError if lines or files cannot be written.

        Args:
            values: channel -> gauge Pa, bit, or None: invalid (of `Bench.sample`).
            silent: no value reaches the board.
        """
        for name, value in carried(values, self._kinds, self._description).items():
            if (channel := self._channels[name]).analog:
                self._show(channel, None if silent or value is None else round(channel.raw(value) / SCALE_MV))
        levels = {} if silent else self.levels(values)
        if levels != self._levels and levels:
            self._pins.drive(levels)
            self._levels = levels

    def levels(self, values: Mapping[str, Value]) -> dict[str, bool]:
        """Return the level of every input line for these values of the sensors."""
        levels: dict[str, bool] = {}
        for name, value in carried(values, self._kinds, self._description).items():
            if digital := (channel := self._channels[name]).digital:
                pulled_up = self._pulls[digital.line] == "up"
                levels[digital.line] = pulled_up if value is None else bool(channel.raw(value))
        return levels

    def close(self) -> None:
        """Stop the output; the board keeps the last levels and values."""
        self._pins.close()

    def _show(self, channel: Channel, count: int | None) -> None:
        assert channel.analog
        file = self._devices[channel.analog.device] / f"in_{channel.analog.channel}_raw"
        if file in self._counts and count == self._counts[file]:
            return
        self._counts[file] = count
        try:
            if count is None:
                file.unlink(missing_ok=True)
                return
            fresh = file.with_name(f".{file.name}.{os.getpid()}")  # a reader finds a whole number
            fresh.write_text(f"{count}\n", encoding="ascii")
            fresh.replace(file)
        except FileNotFoundError:  # somebody has unplugged the device
            return
        except OSError as error:
            raise WireError(f"cannot be written: {error.strerror}.", where=str(file)) from error

    def _device(self, name: str) -> Path:
        """Return the folder of a device, created if necessary as the kernel would; raises OSError."""
        with suppress(WireError):
            return find_device(self._iio, name)
        number = 0
        while (self._iio / f"iio:device{number}").exists():
            number += 1
        folder = self._iio / (name if name.startswith("iio:device") else f"iio:device{number}")
        folder.mkdir(parents=True)
        (folder / "name").write_text(f"{name}\n", encoding="ascii")
        return folder
