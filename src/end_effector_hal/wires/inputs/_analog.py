"""Analog inputs through Linux IIO: text files in sysfs, or a folder with files of the same form.

The value of a channel is ``(raw + offset) * scale`` in the unit of its driver: mV for a voltage, kPa for a pressure.
Source: Documentation/ABI/testing/sysfs-bus-iio of Linux.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Mapping
from pathlib import Path

from end_effector_hal.description import Channel
from end_effector_hal.errors import WireError
from end_effector_hal.signals import Value
from end_effector_hal.vocabulary import hint
from end_effector_hal.wires._clock import Backoff, now_us

LONGEST = 64
"""Most bytes that are read of a number."""


class AnalogReader:
    """Reads analog channels, each from a few files; any error makes the value invalid and is reported.

    Args:
        folder: the folder of the devices.
        channels: the analog channels, by name.
        clock: µs.
    """

    def __init__(
        self, folder: str | Path, channels: Mapping[str, Channel], clock: Callable[[], int] = now_us
    ) -> None:
        self._folder, self._channels = Path(folder), channels
        self._devices: dict[str, Path] = {}
        self._searches = {part.analog.device: Backoff(clock) for part in channels.values() if part.analog}
        self.errors: dict[str, str] = {}
        """Why a channel has no value: sentences, by the name of the channel."""

    def read(self, name: str) -> Value:
        """Return the present value of a channel; None: it has none."""
        channel = self._channels[name]
        analog = channel.analog
        if analog is None:
            return None
        try:
            device = self._device(analog.device)
            if device is None:
                return None
            count, measured = _number(device, analog.channel)
        except (OSError, ValueError) as error:
            self._devices.pop(analog.device, None)  # it may come back under another number
            self.errors[name] = f"{name} cannot be read: {_why(error)}"
            return None
        self.errors.pop(name, None)
        return None if count in channel.invalid else channel.value(measured)

    def _device(self, name: str) -> Path | None:
        """Return the folder of a device; None: not found, the next search comes later."""
        if name not in self._devices:
            search = self._searches[name]
            if not search.is_due():
                return None
            search.failed()
            self._devices[name] = find_device(self._folder, name)
            search.worked()
        return self._devices[name]


def find_device(folder: Path, name: str) -> Path:
    """Return a device's folder, found by its file ``name`` or ``label`` or by its own name; raises WireError."""
    try:
        devices = sorted(each for each in folder.iterdir() if each.is_dir())
    except OSError as error:
        raise WireError(
            f"there are no analog inputs: {error.strerror}.",
            where=str(folder),
            todo="The kernel needs CONFIG_IIO and a driver of the converter; inputs: iio: names another folder.",
        ) from error
    names = {each: [each.name, _text(each / "name"), _text(each / "label")] for each in devices}
    found = [each for each in devices if name in names[each]]
    if len(found) > 1:
        places = " and ".join(each.name for each in found)
        raise WireError(f"{places} are both called {name}.", where=str(folder), todo=f"Name {found[0].name}.")
    if not found:
        known = [each for of_one in names.values() for each in of_one if each]
        todo = f"There are {', '.join(known)}." if known else "The driver of the converter has found none."
        raise WireError(f"there is no analog device {name}{hint(name, known)}.", where=str(folder), todo=todo)
    return found[0]


def _number(device: Path, channel: str) -> tuple[float, float]:
    """Return the raw count of a channel, and its value in the unit of the driver."""
    stem = re.sub(r"\d+", "", channel)  # in_voltage_scale counts for each in_voltage0, in_voltage1
    try:
        count = _finite(device / f"in_{channel}_raw")
    except FileNotFoundError:
        processed = device / f"in_{channel}_input"
        if not processed.exists():
            raise
        value = _finite(processed)
        return value, value
    offset, scale = (
        next(
            (_finite(file) for each in (channel, stem) if (file := device / f"in_{each}_{kind}").exists()),
            otherwise,
        )
        for kind, otherwise in (("offset", 0.0), ("scale", 1.0))
    )
    return count, (count + offset) * scale


def _finite(path: Path) -> float:
    text = _read(path)
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise ValueError(f"{path} contains {text[:20]!r}, which is not a number.")
    return number


def _read(path: Path) -> str:
    """Return the beginning of a file, without waiting (the path may be a pipe)."""
    fd = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    try:
        return os.read(fd, LONGEST).decode("ascii", errors="replace").strip()
    finally:
        os.close(fd)


def _text(path: Path) -> str:
    try:
        return _read(path)
    except OSError:
        return ""


def _why(error: Exception) -> str:
    if isinstance(error, WireError) or not isinstance(error, OSError):
        return str(error)
    return f"{error.filename or 'its file'}: {error.strerror or error}."
