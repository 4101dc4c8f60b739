"""Real lines as inputs (libgpiod's v2 API), and lines of the kernel's simulated chips (gpio-sim)."""

from __future__ import annotations

import errno
import os
import select
import threading
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from end_effector_hal.errors import LineNotFoundError, WireError
from end_effector_hal.kinds.stanza import LineAddress
from end_effector_hal.wires import now_us
from end_effector_hal.wires.lines import find_lines, load_gpiod

from ._virtual import OnEdge

CONSUMER = "end-effector-testbench"


class GpioInputs:
    """Reports edges of real lines, with time stamps of the kernel.

    Args:
        lines: line of the description -> name of the line on this machine.
        text: name of the inputs for people.
        pattern: paths of the chips.
    """

    def __init__(self, lines: Mapping[str, str], text: str, pattern: str = "/dev/gpiochip*") -> None:
        self.text = text
        self.lines, self._pattern = dict(lines), pattern
        self._requests: dict[int, tuple[Any, dict[int, str]]] = {}
        self._thread: threading.Thread | None = None

    def start(self, on_edge: OnEdge) -> dict[str, bool]:
        self._gpiod = load_gpiod()
        levels: dict[str, bool] = {}
        for path, offsets in self._find().items():
            request = self._request(path, offsets)
            self._requests[request.fd] = request, offsets
            values = request.get_values(list(offsets))
            active = self._gpiod.line.Value.ACTIVE
            levels |= {line: value == active for line, value in zip(offsets.values(), values, strict=True)}
        self._wake_read, self._wake = os.pipe()
        self._thread = threading.Thread(target=self._run, args=(on_edge,), name="lines", daemon=True)
        self._thread.start()
        return levels

    def close(self) -> None:
        thread, self._thread = self._thread, None
        if thread is not None:
            os.write(self._wake, b"x")
            thread.join()
            os.close(self._wake)
            os.close(self._wake_read)
        while self._requests:
            self._requests.popitem()[1][0].release()

    def _run(self, on_edge: OnEdge) -> None:
        rising = self._gpiod.EdgeEvent.Type.RISING_EDGE
        while True:
            ready, _, _ = select.select([*self._requests, self._wake_read], [], [])
            if self._wake_read in ready:
                return
            for fd in ready:
                request, offsets = self._requests[fd]
                for event in request.read_edge_events():
                    at = event.timestamp_ns // 1000
                    on_edge(offsets[event.line_offset], event.event_type == rising, at)

    def _find(self) -> dict[str, dict[int, str]]:
        """Return chip -> offset -> line of the description."""
        names = {name: line for line, name in self.lines.items()}
        try:
            found = find_lines(self._gpiod, self._pattern, list(names))
        except LineNotFoundError as error:
            todo = f"{error.todo} --lines gpiod:LINE=NAME,... names others."
            raise LineNotFoundError(error.what, where=error.where, todo=todo) from None
        chips: dict[str, dict[int, str]] = {}
        for name, (path, offset) in found.items():
            chips.setdefault(path, {})[offset] = names[name]
        return chips

    def _request(self, path: str, offsets: Mapping[int, str]) -> Any:
        """Request the lines as inputs with edge events; pulled down, so that a disconnected wire is inactive."""
        line = self._gpiod.line
        settings = self._gpiod.LineSettings(
            direction=line.Direction.INPUT,
            edge_detection=line.Edge.BOTH,
            bias=line.Bias.PULL_DOWN,
            event_clock=line.Clock.MONOTONIC,
        )
        try:
            return self._gpiod.request_lines(path, consumer=CONSUMER, config={tuple(offsets): settings})
        except OSError as error:
            raise _refused(path, error) from error


def _refused(path: str, error: OSError) -> WireError:
    todo = {
        errno.EACCES: "Add the user to the group gpio and log in again.",
        errno.EBUSY: "gpioinfo shows who holds a line: stop that program.",
    }.get(error.errno or 0, "The controller gives no edges of these lines: use others, or see dmesg.")
    return WireError(f"the GPIO lines cannot be used: {error.strerror}.", where=path, todo=todo)


CONFIG, DEVICES = Path("/sys/kernel/config/gpio-sim"), Path("/sys/devices/platform")
NAME = "end-effector-testbench"
PERIOD_S = 0.001


class GpioSimInputs:
    """Reads lines that a HAL on this machine drives through ``/dev/gpiochip*``.

    The kernel does not report changes (no poll, no inotify on these files): they are read once a millisecond. A chip
    with these lines is made if there is none, and remains afterwards.

    Args:
        names: names of the lines.
        config: folder in which chips are made (configfs).
        devices: folder with their levels (sysfs).
    """

    def __init__(self, names: Iterable[str], config: Path = CONFIG, devices: Path = DEVICES) -> None:
        self._names, self._config, self._devices = tuple(names), config, devices
        self._files: dict[str, int] = {}
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    @property
    def text(self) -> str:
        return "gpio-sim"

    def start(self, on_edge: OnEdge) -> dict[str, bool]:
        try:
            found = self._found()
            if not any(name in found for name in self._names):
                self._make()
                found = self._found()
            if missing := [name for name in self._names if name not in found]:
                named = [name for name in found if name and LineAddress.of(name) is None]
                raise LineNotFoundError(
                    f"the simulated GPIO chips have no line {', '.join(missing)}, only {', '.join(named or found)}.",
                    where=str(self._config),
                    todo="They were made for another tool: remove them.",
                )
            self._files = {name: os.open(found[name], os.O_RDONLY | os.O_CLOEXEC) for name in self._names}
            levels = self._read()
        except OSError as error:
            self.close()
            if isinstance(error, WireError):
                raise
            raise WireError(
                f"simulated GPIO chips cannot be used: {error.strerror}.",
                where=str(error.filename or self._config),
                todo="It needs root, a kernel with CONFIG_GPIO_SIM (modprobe gpio-sim), and configfs mounted.",
            ) from error
        self._thread = threading.Thread(
            target=self._run, args=(on_edge, dict(levels)), name="lines", daemon=True
        )
        self._thread.start()
        return levels

    def close(self) -> None:
        thread, self._thread = self._thread, None
        self._stop.set()
        if thread is not None:
            thread.join()
        while self._files:
            os.close(self._files.popitem()[1])

    def _run(self, on_edge: OnEdge, levels: dict[str, bool]) -> None:
        while not self._stop.wait(PERIOD_S):
            for name, level in self._read().items():
                if level != levels[name]:
                    levels[name] = level
                    on_edge(name, level, now_us())

    def _read(self) -> dict[str, bool]:
        return {name: os.pread(fd, 8, 0).startswith(b"1") for name, fd in self._files.items()}

    def _found(self) -> dict[str, Path]:
        """Return line -> file with its level, for all active chips: by name, else by the chip's name and label."""
        found = dict[str, Path]()
        for bank in sorted(self._config.glob("*/*/chip_name")):
            device, chip, label = bank.parent.parent / "dev_name", _text(bank), _text(bank.with_name("label"))
            for level in (self._devices / _text(device) / chip).glob("sim_gpio*/value"):
                offset = int(level.parent.name.removeprefix("sim_gpio"))
                texts = (str(LineAddress(name, offset)) for name in (chip, label) if name)
                found |= dict.fromkeys([_text(bank.with_name(f"line{offset}") / "name"), *texts], level)
        return found

    def _make(self) -> None:
        """Make a chip with the names, and one for each label, which has as many lines as are needed."""
        addresses = [each for each in map(LineAddress.of, self._names) if each]
        names = [name for name in self._names if LineAddress.of(name) is None]
        sizes = {NAME: len(names)} if names else {}
        for label, offset in addresses:
            sizes[label] = max(sizes.get(label, 0), offset + 1)
        for number, (label, size) in enumerate(sizes.items()):
            bank = self._config / NAME / f"bank{number}"
            bank.mkdir(parents=True, exist_ok=True)
            (bank / "num_lines").write_text(str(size))
            (bank / "label").write_text(label)
            for offset, name in enumerate(names if label == NAME else ()):
                (bank / f"line{offset}").mkdir(exist_ok=True)
                (bank / f"line{offset}" / "name").write_text(name)
        (self._config / NAME / "live").write_text("1")


def _text(path: Path) -> str:
    """Return the text of a file; empty if there is none, as for a line without a name."""
    return path.read_text().strip() if path.exists() else ""
