"""The paper's scenarios on a real GPIO chip and a real serial driver: the HAL inside, the testbench outside."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest
from guest import Ended, run_guest
from rich.console import Console
from same_story import differences
from seen import edges_of

from end_effector_hal.demo import judge, run_demo, scenarios
from end_effector_hal.demo._children import Children
from end_effector_hal.demo._pictures import draw
from end_effector_hal.demo._world import EEHAL
from end_effector_hal.description import Description
from end_effector_hal.trace import StatesLog, read_run, read_states

TOLERANCE_S = 0.1
"""Of each step: frames come every 20 ms, so that it may end one earlier or later; the rest is for a busy machine."""
NAMES = ("nominal", "fails-once", "never-confirms")


@pytest.fixture(scope="session")
def on_virtual_lines(tool: Description, runs: Path) -> Callable[[str], StatesLog]:
    """The same scenario on virtual lines and a pty, without a guest."""

    @cache
    def recording(name: str) -> StatesLog:
        (scenario,) = (each for each in scenarios(tool) if each.name == name)
        folder = runs / "virtual"
        (report,) = run_demo(tool, [scenario], folder, ros=False, progress=Console(quiet=True), figures=False)
        assert report.faults == ()
        return read_states(folder / name / "states.csv")

    return recording


def play(kernel: Path, tool: Description, name: str, folder: Path, place: Path, *, ros: bool) -> Ended:
    """One scenario in one guest; its recording stays in ``folder``, its sockets are made in ``place``."""
    (scenario,) = (each for each in scenarios(tool) if each.name == name)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    chip, uart = place / "chip", place / "uart"
    with Children() as children:
        testbench = children.start(
            "testbench",
            [
                *EEHAL, "testbench", str(tool.source), "--scenario", scenario.bench,
                "--lines", f"virtio-gpio:{chip}", "--port", f"pty:{uart}", "--events", str(folder / "events"),
            ],
            log=folder / "testbench.log",
            commands=True,
        )  # fmt: skip
        testbench.wait_until(lambda: "ready:" in testbench.text(), timeout_s=60, what="it was ready")
        options = f"--own-wires --no-figures --only {name}" + ("" if ros else " --no-ros")
        command = f"eehal demo {tool.source} {options} -o {folder / 'demo'}"
        return run_guest(kernel, folder, command, chip=chip, uart=uart, timeout_s=400)


@pytest.mark.parametrize("ros", [False, True], ids=["core", "ros"])
@pytest.mark.parametrize("name", NAMES)
def test_a_scenario_tells_the_same_story_as_on_virtual_lines(
    kernel: Path,
    tool: Description,
    runs: Path,
    place: Path,
    on_virtual_lines: Callable[[str], StatesLog],
    name: str,
    ros: bool,
    capsys: pytest.CaptureFixture[str],
) -> None:
    folder = runs / ("ros" if ros else "core") / name
    ended = play(kernel, tool, name, folder, place, ros=ros)
    # 1: a time-out was not within 100 ms after its nominal time, as the demo asks of a machine of its own
    assert ended.code in (0, 1), ended.console + ended.output
    recorded = folder / "demo" / name
    log, info = read_states(recorded / "states.csv"), read_run(recorded)
    draw(recorded, log, info)
    (scenario,) = (each for each in scenarios(tool) if each.name == name)
    report = judge(scenario, tool, log, info, edges_of(folder / "events"))
    assert [str(finding) for finding in report.findings if not finding.ok] == []
    longer_s = differences(on_virtual_lines(name), log)
    worst_s = max(map(abs, longer_s))
    with capsys.disabled():
        print(  # noqa: T201 asked for
            f"\n{name} {'through ROS' if ros else 'without ROS'}: at most {worst_s * 1000:.0f} ms between a step here "
            f"and on virtual lines; {ended.seconds:.0f} s from boot to power-off"
        )
    assert worst_s <= TOLERANCE_S, longer_s
