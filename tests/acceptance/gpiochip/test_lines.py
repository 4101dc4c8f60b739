"""The kernel's GPIO character device against our back-ends: what `inside/` checks in the guest, seen from both ends."""

from __future__ import annotations

from pathlib import Path
from queue import Queue

from end_effector_hal.description import Description
from tests.acceptance.gpiochip.guest import HERE, run_guest
from tests.acceptance.gpiochip.machines import Machine
from tools.virtio_gpio import VirtioGpioInputs

PYTEST = "pytest -q -p no:cacheprovider --timeout 240"
LONGEST_S = 240.0


def test_the_kernels_simulated_chip(machine: Machine, tmp_path: Path, place: Path) -> None:
    ended = machine.run(place, tmp_path, f"{PYTEST} {HERE}/inside/check_gpio_sim.py", LONGEST_S)
    assert ended.code == 0, ended.console + ended.output
    assert "skipped" not in ended.output


def test_inputs_of_the_kernels_simulated_chip(machine: Machine, tmp_path: Path, place: Path) -> None:
    """Bias, debounce, edges with the kernel's time, and a whole tool whose sensors are lines of the board."""
    ended = machine.run(place, tmp_path, f"{PYTEST} {HERE}/inside/check_inputs.py", LONGEST_S)
    assert ended.code == 0, ended.console + ended.output
    assert "skipped" not in ended.output


def test_the_chip_that_the_testbench_is(kernel: Path, tool: Description, tmp_path: Path, place: Path) -> None:
    names = sorted(tool.output_lines)
    seen: Queue[tuple[str, bool]] = Queue()
    chip = VirtioGpioInputs(place / "chip", names)
    chip.start(lambda line, level, _at: seen.put((line, level)))
    try:
        command = f"EEHAL_TOOL={tool.source} {PYTEST} {HERE}/inside/check_virtio.py"
        ended = run_guest(kernel, tmp_path, command, chip=place / "chip")
    finally:
        chip.close()
    assert ended.code == 0, ended.console + ended.output
    edges = [seen.get_nowait() for _ in range(seen.qsize())]
    by_line = {name: [level for line, level in edges if line == name] for name in names}
    for name, levels in by_line.items():
        assert levels == [True, False] * (len(levels) // 2), f"{name}: what was driven has fallen"
    assert by_line["SODIMM_206"]
    # the arbiter that was killed with both active: they fall together, with nobody left to write
    assert falls_together(edges)


def falls_together(edges: list[tuple[str, bool]]) -> bool:
    pair = [("SODIMM_206", True), ("SODIMM_212", True), ("SODIMM_206", False), ("SODIMM_212", False)]
    return any(edges[start : start + 4] == pair for start in range(len(edges)))
