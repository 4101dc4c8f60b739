"""Every side on which the testbench sees lines, by one conformance test; the kernel's parts are stand-ins."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path
from queue import Queue
from types import SimpleNamespace

import pytest

from end_effector_hal.errors import LineNotFoundError, WireError
from end_effector_hal.wires import now_us
from end_effector_hal.wires.lines import VirtualLines
from end_effector_hal.wires.lines import _gpiod as gpio_module
from end_effector_lab.testbench.inputs import (
    GpioInputs,
    GpioSimInputs,
    VirtualInputs,
)
from tests.acceptance.testbench.emulator import Emulator
from tests.support.gpio_kernel import Kernel, Kind
from tests.support.line_inputs_tests import A, B, LineInputsConformance, Wires
from tests.support.patience import PATIENCE_S
from tests.support.virtual_machine import VirtualMachine
from tools.board import QemuInputs
from tools.virtio_gpio import VirtioGpioInputs

pytestmark = pytest.mark.wall


class TestVirtual(LineInputsConformance):
    @pytest.fixture
    def wires(self, tmp_path: Path) -> Iterator[Wires]:
        lines = VirtualLines(tmp_path / "chip")
        claimed: list[str] = []

        def drive(line: str, level: bool) -> None:
            if not claimed:
                claimed.extend(lines.request([A, B]))
            lines.set({line: level})

        inputs = VirtualInputs(tmp_path / "chip", [A, B])
        yield SimpleNamespace(inputs=inputs, drive=drive)
        inputs.close()
        lines.close()


class TestGpiod(LineInputsConformance):
    at_is_now = True

    @pytest.fixture
    def wires(self, monkeypatch: pytest.MonkeyPatch) -> Iterator[Wires]:
        kernel = Kernel({"/dev/null": [A, "", B]})
        monkeypatch.setattr(gpio_module, "importlib", SimpleNamespace(import_module=lambda name: kernel))
        levels: dict[str, bool] = {}

        def drive(line: str, level: bool) -> None:
            if level != levels.get(line, False):
                kind = Kind.RISING_EDGE if level else Kind.FALLING_EDGE
                kernel.requests["/dev/null"].happen({A: 0, B: 2}[line], kind, now_us())
            levels[line] = level

        inputs = GpioInputs({A: A, B: B}, "gpiod", "/dev/nul[l]")
        yield SimpleNamespace(inputs=inputs, drive=drive)
        inputs.close()


class TestGpioSim(LineInputsConformance):
    @pytest.fixture
    def wires(self, tmp_path: Path) -> Iterator[Wires]:
        simulated(tmp_path, [A, B])
        inputs = GpioSimInputs([A, B], tmp_path / "config", tmp_path / "devices")

        def drive(line: str, level: bool) -> None:
            with level_file(tmp_path, {A: 0, B: 1}[line]).open("r+") as file:  # never empty, as in sysfs
                file.write(f"{level:d}")

        yield SimpleNamespace(inputs=inputs, drive=drive)
        inputs.close()


class TestVirtioGpio(LineInputsConformance):
    @pytest.fixture
    def wires(self, tmp_path: Path) -> Iterator[Wires]:
        inputs = VirtioGpioInputs(tmp_path / "chip.sock", [A, B])
        running: list[VirtualMachine] = []

        def drive(line: str, level: bool) -> None:
            if not running:
                running.append(VirtualMachine(tmp_path / "chip.sock").boot())
            running[0].drive({A: 0, B: 1}[line], level)

        yield SimpleNamespace(inputs=inputs, drive=drive)
        inputs.close()
        for machine in running:
            machine.off()


class TestQemu(LineInputsConformance):
    at_is_now = False

    @pytest.fixture
    def wires(self, tmp_path: Path) -> Iterator[Wires]:
        machine = Emulator(tmp_path / "qtest")
        pins = {A: 0, B: 5}
        inputs = QemuInputs(str(tmp_path / "qtest"), pins)
        yield SimpleNamespace(inputs=inputs, drive=lambda line, level: machine.drive(pins[line], level))
        inputs.close()
        machine.off()


def test_an_emulated_machine_that_ends_drives_nothing(tmp_path: Path) -> None:
    machine, seen = Emulator(tmp_path / "qtest"), Queue[tuple[str, bool]]()
    inputs = QemuInputs(str(tmp_path / "qtest"), {A: 0, B: 5})
    inputs.start(lambda line, level, _at: seen.put((line, level)))
    machine.drive(7, True)
    machine.drive(5, True)
    machine.off()
    assert [seen.get(timeout=PATIENCE_S), seen.get(timeout=PATIENCE_S)] == [(B, True), (B, False)]
    inputs.close()


def test_the_edges_of_an_emulated_machine_are_in_its_own_time(tmp_path: Path) -> None:
    machine, seen = Emulator(tmp_path / "qtest"), Queue[tuple[str, bool, int]]()
    machine.ticks = 2**32 - 32768
    inputs = QemuInputs(str(tmp_path / "qtest"), {A: 0})
    inputs.start(lambda *edge: seen.put(edge))
    assert inputs.clock.now_us() == 0
    for seconds, level in [(1, True), (1.5, False)]:
        machine.ticks = 2**32 - 32768 + int(seconds * 32768)  # past its end, to begin anew
        machine.drive(0, level)
        assert seen.get(timeout=20) == (A, level, seconds * 1_000_000)
    inputs.close()
    machine.off()


def test_an_emulated_machine_without_the_controller(tmp_path: Path) -> None:
    machine = Emulator(tmp_path / "qtest", controller="/machine/other")
    with pytest.raises(WireError, match=r"no GPIO controller /machine/soc/gpio1: FAIL Unknown device"):
        QemuInputs(str(tmp_path / "qtest"), {A: 0}).start(lambda *_: None)
    machine.off()


def test_the_emulated_machine_may_come_later(tmp_path: Path) -> None:
    inputs, started = QemuInputs(str(tmp_path / "qtest"), {A: 0}), Queue[dict[str, bool]]()
    waiting = threading.Thread(target=lambda: started.put(inputs.start(lambda *_: None)))
    waiting.start()
    machine = Emulator(tmp_path / "qtest")
    assert started.get(timeout=PATIENCE_S) == {A: False}
    waiting.join()
    inputs.close()
    machine.off()


def test_no_emulated_machine(tmp_path: Path) -> None:
    with pytest.raises(WireError, match="Start QEMU with -qtest"):
        QemuInputs(str(tmp_path / "qtest"), {A: 0}, patience_s=0.1).start(lambda *_: None)


def level_file(tmp_path: Path, number: int) -> Path:
    return tmp_path / f"devices/gpio-sim.0/gpiochip1/sim_gpio{number}/value"


def simulated(tmp_path: Path, names: list[str]) -> None:
    """A chip of gpio-sim as it stands in configfs and sysfs."""
    chip = tmp_path / "config" / "chip"
    for number, name in enumerate(names):
        (chip / "bank0" / f"line{number}").mkdir(parents=True)
        (chip / "bank0" / f"line{number}" / "name").write_text(f"{name}\n")
        level_file(tmp_path, number).parent.mkdir(parents=True)
        level_file(tmp_path, number).write_text("0\n")
    (chip / "dev_name").write_text("gpio-sim.0\n")
    (chip / "bank0" / "chip_name").write_text("gpiochip1\n")


def test_simulated_lines_of_another_tool(tmp_path: Path) -> None:
    simulated(tmp_path, [A, "other"])
    with pytest.raises(LineNotFoundError, match=rf"have no line {B}, only {A}, other"):
        GpioSimInputs([A, B], tmp_path / "config", tmp_path / "devices").start(lambda *_: None)


def test_a_kernel_without_simulated_chips(tmp_path: Path) -> None:
    with pytest.raises(WireError, match=r"modprobe gpio-sim"):
        GpioSimInputs([A], Path("/proc/no/gpio-sim"), tmp_path).start(lambda *_: None)
