from __future__ import annotations

from pathlib import Path
from queue import Queue

import pytest

from end_effector_hal.errors import LineBusyError, LineNotFoundError, WireError
from end_effector_hal.wires.lines import VirtualChip, VirtualLines
from end_effector_lab.testbench.inputs import VirtualInputs
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
