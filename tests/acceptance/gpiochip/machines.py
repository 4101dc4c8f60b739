"""Where the HAL runs on a GPIO chip of the kernel: a guest with a kernel of its own, or this machine with gpio-sim."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from end_effector_lab.processes import EEHAL
from tests.acceptance.gpiochip.guest import READY, Ended, run_guest

GPIO_SIM = Path("/sys/kernel/config/gpio-sim")


class Machine(Protocol):
    """A machine with a chip and a serial port, and what a testbench needs to be at their other ends."""

    name: str

    def testbench(self, place: Path) -> list[str]:
        """The command of the testbench with ``--lines``."""

    def port(self, place: Path) -> str:
        """Of the description: the serial port as the HAL sees it. The testbench's end is PLACE/uart."""

    def run(self, place: Path, folder: Path, command: str, timeout_s: float) -> Ended:
        """Run a command of the shell; what it leaves in $RESULTS comes into ``folder``."""


@dataclass(frozen=True)
class Guest:
    """User-Mode-Linux; the testbench is its chip."""

    kernel: Path
    name: str = "gpio-virtio"

    def testbench(self, place: Path) -> list[str]:
        return [sys.executable, "-m", "tools.testbench", "--lines", f"virtio-gpio:{place / 'chip'}"]

    def port(self, _place: Path) -> str:
        return "/dev/ttyS0"

    def run(self, place: Path, folder: Path, command: str, timeout_s: float) -> Ended:
        chip, uart = (path if path.exists() else None for path in (place / "chip", place / "uart"))
        return run_guest(self.kernel, folder, command, chip=chip, uart=uart, timeout_s=timeout_s)


@dataclass(frozen=True)
class ThisMachine:
    """The kernel of this machine, where it has gpio-sim; the testbench makes the chip."""

    name: str = "gpio-sim"

    def testbench(self, _place: Path) -> list[str]:
        return [*EEHAL, "testbench", "--lines", "gpio-sim"]

    def port(self, place: Path) -> str:
        return str(place / "uart")

    def run(self, _place: Path, folder: Path, command: str, timeout_s: float) -> Ended:
        begun = time.monotonic()
        with (folder / "output").open("w") as output:
            process = subprocess.run(
                ["timeout", str(timeout_s), "sh", "-c", READY + command],
                env={**os.environ, "RESULTS": str(folder)},
                stdout=output, stderr=output, check=False,
            )  # fmt: skip
        seconds = time.monotonic() - begun
        return Ended(process.returncode, (folder / "output").read_text(errors="replace"), "", seconds)


def lacks_gpio_sim() -> str:
    """What keeps this machine from simulating chips, as a sentence; empty: nothing."""
    if os.geteuid() != 0:
        return "gpio-sim is made by root only: run it with sudo."
    if not GPIO_SIM.is_dir() and shutil.which("modprobe"):
        subprocess.run(["modprobe", "-q", "gpio-sim"], check=False)
    if not GPIO_SIM.is_dir():
        return (
            f"This machine has no {GPIO_SIM}: it needs a kernel with CONFIG_GPIO_SIM, and configfs mounted."
        )
    return ""
