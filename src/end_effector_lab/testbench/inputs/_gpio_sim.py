"""Lines of the kernel's simulated GPIO chips (gpio-sim), on a machine whose kernel has them."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterable
from pathlib import Path

from end_effector_hal.errors import LineNotFoundError, WireError
from end_effector_hal.wires import now_us

from ._inputs import OnEdge

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
                raise LineNotFoundError(
                    f"the simulated GPIO chips have no line {', '.join(missing)}, only {', '.join(found)}.",
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
        """Return line -> file with its level, for all active chips."""
        found = {}
        for line in sorted(self._config.glob("*/*/line*")):
            bank, number = line.parent, line.name.removeprefix("line")
            chip = self._devices / _text(bank.parent / "dev_name") / _text(bank / "chip_name")
            level = chip / f"sim_gpio{number}" / "value"
            if level.exists():
                found[_text(line / "name")] = level
        return found

    def _make(self) -> None:
        chip = self._config / NAME
        bank = chip / "bank0"
        bank.mkdir(parents=True, exist_ok=True)
        (bank / "num_lines").write_text(str(len(self._names)))
        (bank / "label").write_text(NAME)
        for number, name in enumerate(self._names):
            (bank / f"line{number}").mkdir(exist_ok=True)
            (bank / f"line{number}" / "name").write_text(name)
        (chip / "live").write_text("1")


def _text(path: Path) -> str:
    return path.read_text().strip()
