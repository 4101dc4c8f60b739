"""Where the testbench sees the lines: virtual chips, and the Raspberry Pi's inputs on a stand-in for the kernel."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from queue import Queue
from types import SimpleNamespace
from typing import Any

import pytest

from end_effector_hal.errors import LineBusyError, LineNotFoundError, WireError
from end_effector_hal.wires.lines import VirtualChip, VirtualLines
from end_effector_hal.wires.lines import _gpiod as module
from end_effector_lab.testbench.inputs import GpioInputs, VirtualInputs
from tests.support.gpio_kernel import Kernel, Kind, Request
from tests.support.patience import PATIENCE_S

NAMES = ["A", "B"]


def ignore(line: str, level: bool, at: int) -> None:
    pass


def test_makes_the_chip_that_is_missing_and_tells_edges(tmp_path: Path) -> None:
    path = tmp_path / "run" / "chip"
    seen: Queue[tuple[str, bool]] = Queue()
    inputs = VirtualInputs(path, NAMES)
    assert inputs.start(lambda line, level, at: seen.put((line, level))) == {"A": False, "B": False}
    lines = VirtualLines(path)
    lines.request(NAMES)
    lines.set({"B": True})
    while (edge := seen.get(timeout=PATIENCE_S)) != ("B", True):
        assert edge[1] is False  # from inputs to outputs
    inputs.close()
    lines.close()


def test_a_chip_that_exists_keeps_its_levels(tmp_path: Path) -> None:
    path = tmp_path / "chip"
    VirtualChip.create(path, NAMES)
    lines = VirtualLines(path)
    lines.request(NAMES)
    lines.set({"A": True})
    with pytest.raises(LineBusyError):  # somebody drives them
        VirtualInputs(path, NAMES, power_cycle=True).start(ignore)
    lines.close()
    inputs = VirtualInputs(path, NAMES)
    assert inputs.start(ignore) == {"A": True, "B": False}
    inputs.close()
    inputs = VirtualInputs(path, NAMES, power_cycle=True)
    assert inputs.start(ignore) == {"A": False, "B": False}
    inputs.close()


def test_a_pulled_up_input_is_seen_as_a_pin_is(tmp_path: Path) -> None:
    VirtualChip.create(tmp_path / "chip", NAMES, {"B": "up"})
    seen: Queue[tuple[str, bool]] = Queue()
    inputs = VirtualInputs(tmp_path / "chip", NAMES)
    assert inputs.start(lambda line, level, at: seen.put((line, level))) == {"A": False, "B": True}
    VirtualChip.create(tmp_path / "chip", NAMES, {"A": "up"})  # a power-up
    assert {seen.get(timeout=PATIENCE_S), seen.get(timeout=PATIENCE_S)} == {("A", True), ("B", False)}
    inputs.close()


def test_the_chip_of_another_tool(tmp_path: Path) -> None:
    VirtualChip.create(tmp_path / "chip", ["A", "C"])
    with pytest.raises(LineNotFoundError, match="has no line B, only A, C"):
        VirtualInputs(tmp_path / "chip", NAMES).start(ignore)


def test_lines_that_belong_to_nobody_are_not_told(tmp_path: Path) -> None:
    path = tmp_path / "chip"
    VirtualChip.create(path, [*NAMES, "C"])
    seen: Queue[str] = Queue()
    inputs = VirtualInputs(path, NAMES)
    inputs.start(lambda line, level, at: seen.put(line))
    lines = VirtualLines(path)
    lines.request(["C", "B"])
    lines.set({"C": True})
    lines.set({"B": True})
    while (line := seen.get(timeout=PATIENCE_S)) != "B":
        assert line != "C"
    inputs.close()
    lines.close()


def test_a_place_where_nothing_can_be_made() -> None:
    with pytest.raises(WireError, match="Give another path"):
        VirtualInputs("/proc/none/chip", NAMES).start(ignore)


@pytest.fixture
def kernel(monkeypatch: pytest.MonkeyPatch) -> Iterator[Kernel]:
    kernel = Kernel()
    monkeypatch.setattr(module, "importlib", SimpleNamespace(import_module=lambda name: kernel))
    yield kernel
    assert all(request.released for request in kernel.requests.values())


def inputs(**lines: str) -> GpioInputs:
    return GpioInputs(lines, "test", "/dev/[nz]*")


def test_levels_and_edges_of_lines_on_two_chips(kernel: Kernel) -> None:
    kernel.active = {("/dev/null", 2)}
    seen: Queue[tuple[str, bool, int]] = Queue()
    lines = inputs(changer="GPIO19", bottom="GPIO16", cylinder="GPIO26")
    levels = lines.start(lambda *edge: seen.put(edge))
    assert levels == {"changer": False, "bottom": True, "cylinder": False}
    kernel.requests["/dev/zero"].happen(0, Kind.RISING_EDGE, 5_000_123)
    assert seen.get(timeout=PATIENCE_S) == ("cylinder", True, 5_000_123)
    kernel.requests["/dev/null"].happen(2, Kind.FALLING_EDGE, 6_000_000)
    assert seen.get(timeout=PATIENCE_S) == ("bottom", False, 6_000_000)
    lines.close()


@pytest.mark.parametrize(
    ("name", "count"), [("GPIO99", "there is no line GPIO99"), ("TWIN", "TWIN is ambiguous")]
)
def test_a_name_that_is_missing_or_ambiguous(kernel: Kernel, name: str, count: str) -> None:
    with pytest.raises(LineNotFoundError, match=rf"{count}.*gpiod:LINE=NAME"):
        inputs(bottom=name).start(ignore)


def test_lines_that_somebody_holds(kernel: Kernel) -> None:
    kernel.busy = True
    with pytest.raises(WireError, match=r"busy.*who holds a line"):
        inputs(bottom="GPIO16").start(ignore)


def test_a_controller_without_interrupts(kernel: Kernel) -> None:
    def refuse(*_: Any, **__: Any) -> Request:
        raise OSError(6, "No such device or address")

    kernel.request_lines = refuse  # type: ignore[method-assign]
    with pytest.raises(WireError, match=r"No such device or address.*gives no edges"):
        inputs(bottom="GPIO16").start(ignore)


def test_the_second_chip_refusing_gives_back_the_first(kernel: Kernel) -> None:
    lines = inputs(bottom="GPIO16", cylinder="GPIO26")
    first = kernel.request_lines

    def refuse_the_second(path: str, **options: Any) -> Request:
        kernel.busy = bool(kernel.requests)
        return first(path, **options)

    kernel.request_lines = refuse_the_second  # type: ignore[method-assign]
    with pytest.raises(WireError):
        lines.start(ignore)
    lines.close()


def test_debians_old_module_is_refused(kernel: Kernel) -> None:
    kernel.api_version = "1.6"
    with pytest.raises(WireError, match=r"API 1\.6, needed is 2"):
        inputs(bottom="GPIO16").start(ignore)
