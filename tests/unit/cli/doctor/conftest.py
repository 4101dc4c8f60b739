"""The folder of a tool that the doctor looks at: its wires, a line arbiter that serves it, frames."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from end_effector_hal.arbiter import ArbiterServer, arbiter_policy
from end_effector_hal.cli.doctor import _doctor
from end_effector_hal.codecs import get_codec
from end_effector_hal.description import load, profile_path
from end_effector_hal.signals import Frame
from end_effector_hal.wires.lines import VirtualChip, VirtualLines
from end_effector_hal.wires.link import PtyPair

LINES = load(profile_path()).output_lines
CODEC = get_codec("ees1-ascii")
PRESSURES = {"bottom": -70_000, "cylinder": 600_000, "top": 0, "supply": 600_000}


class Machine:
    """A folder with the wires of a tool, and the doctor who looks at them."""

    def __init__(self, folder: Path) -> None:
        self.chip, self.port, self.socket = folder / "chip", folder / "uart", folder / "arbiter.sock"
        self.path = folder / "tool.yaml"
        self.describe()

    def describe(self, codec: str = "ees1-ascii", text: str = "") -> None:
        """Write the description: the shipped one on this folder's wires."""
        shipped = profile_path().read_text(encoding="utf-8")
        virtual = f"backend: virtual\n  path: {self.chip}\n  socket: {self.socket}\n"
        shipped = shipped.replace("backend: gpiod", virtual).replace("/dev/verdin-uart1", str(self.port))
        self.path.write_text(text or shipped.replace("codec: ees1-ascii", f"codec: {codec}"))

    def make_chip(self) -> None:
        """As the testbench does."""
        VirtualChip.create(self.chip, LINES)

    def doctor(self, *arguments: str) -> Result:
        """Run the command."""
        return CliRunner().invoke(_doctor.command, [str(self.path), *arguments], catch_exceptions=False)

    def findings(self, part: str, *arguments: str) -> list[tuple[str, str, str]]:
        """Level, sentence and advice of one part."""
        told = json.loads(self.doctor("--only", part, "--json", *arguments).stdout)["findings"]
        return [(each["status"], each["what"], each["todo"]) for each in told if each["part"] == part]

    def finding(self, part: str, *arguments: str) -> tuple[str, str, str]:
        """The only one."""
        (only,) = self.findings(part, *arguments)
        return only


@contextmanager
def serving(machine: Machine) -> Iterator[ArbiterServer]:
    """A line arbiter in a thread, with the policy of the tool."""
    machine.make_chip()
    policy = replace(arbiter_policy(load(machine.path)), min_switch_us=0)
    with ArbiterServer(VirtualLines(machine.chip), machine.socket, policy) as running:
        thread = threading.Thread(target=running.run)
        thread.start()
        try:
            yield running
        finally:
            running.stop()
            thread.join()


class Sender(threading.Thread):
    """Writes to a pty until the end of the block, at 500 Hz."""

    def __init__(self, pty: PtyPair, message: Callable[[int], bytes]) -> None:
        super().__init__()
        self._pty, self._message, self._end = pty, message, threading.Event()

    def run(self) -> None:
        number = 0
        while not self._end.wait(0.002):
            self._pty.write(self._message(number))
            number += 1

    def __enter__(self) -> Sender:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._end.set()
        self.join()


def frame(number: int, **values: int | None) -> bytes:
    return CODEC.encode(Frame(0, number, 20 * number, {**PRESSURES, **values}))


# A tool on wires of its own, and a line arbiter that serves it.


@pytest.fixture
def machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Machine:
    for name in ("ROS_MASTER_URI", "ROS_VERSION", "AMENT_PREFIX_PATH"):
        monkeypatch.delenv(name, raising=False)
    return Machine(tmp_path)


@pytest.fixture
def arbiter(machine: Machine) -> Iterator[ArbiterServer]:
    with serving(machine) as running:
        yield running
