"""The emulated Verdin: its device tree, its GPIO controller, its UART, arm64 ROS of Debian; the testbench outside."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest
from rich.console import Console

from end_effector_hal.description import load, profile_path
from end_effector_hal.recording import StatesLog, read_states
from end_effector_lab.demo import DemoScenario, WithoutRos, run_demo, scenarios
from end_effector_lab.testbench import edges_of
from tests.acceptance.gpiochip.same_story import differences
from tests.support.places import ROOT
from tools.board import play_on_board, run_board

TOOL = load(profile_path())
SCENARIOS = {scenario.name: scenario for scenario in scenarios(TOOL)}
TOLERANCE_S = 0.1
"""Of each step: frames come every 20 ms, so that it may end one earlier or later; the rest is for a busy machine."""


@pytest.fixture(scope="session")
def others(runs: Path) -> Callable[[DemoScenario], dict[str, StatesLog]]:
    """The same scenario on virtual lines, and on a real GPIO chip where `make test-gpiochip` has left it."""

    @cache
    def recordings(name: str) -> dict[str, StatesLog]:
        folder = runs / "board-tests" / "virtual"
        (report,) = run_demo(
            TOOL, [SCENARIOS[name]], folder, drive=WithoutRos(), progress=Console(quiet=True), figures=False
        )
        assert [finding for finding in report.findings if not finding.ok] == []
        places = {
            "on virtual lines": folder / name,
            "on the real GPIO chip": runs / "gpiochip" / "core" / name / "demo" / name,
            "on the real GPIO chip through all nodes": runs / "gpiochip" / "ros" / name / "demo" / name,
        }
        logs = {where: place / "states.csv" for where, place in places.items()}
        return {where: read_states(log) for where, log in logs.items() if log.exists()}

    return lambda scenario: recordings(scenario.name)


@pytest.mark.parametrize("ros", [False, True], ids=["core", "ros"])
@pytest.mark.parametrize("name", SCENARIOS)
def test_a_scenario_tells_the_same_story_as_everywhere(
    parts: Path,
    runs: Path,
    others: Callable[[DemoScenario], dict[str, StatesLog]],
    name: str,
    ros: bool,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """The shipped description, unchanged: its line names are found on gpio-mxc, its port is the board's."""
    scenario = SCENARIOS[name]
    folder = runs / "board-tests" / ("ros" if ros else "core") / name
    played = play_on_board(scenario, TOOL, parts, folder, ros=ros)
    for line in ("SODIMM_206 = /dev/gpiochip0 line 0", "SODIMM_212 = /dev/gpiochip0 line 6"):
        assert line in (folder / "results" / "output").read_text()
    assert played.faults == ()
    here = read_states(folder / "states.csv")
    how = "through all nodes" if ros else "without ROS"
    said = [f"\n{name} {how}: {played.seconds:.0f} s from power-up to power-off"]
    worst = {}
    for where, there in others(scenario).items():
        worst[where] = max(map(abs, differences(there, here)))
        said.append(f"  at most {worst[where] * 1000:.0f} ms between a step here and {where}")
    with capsys.disabled():
        print("\n".join(said))  # noqa: T201 asked for
    assert max(worst.values()) <= TOLERANCE_S, worst


def test_another_story_is_told_as_such(parts: Path, runs: Path) -> None:
    """The judge looks at this very recording: with the testbench of another scenario it objects."""
    nominal, other = SCENARIOS["nominal"], SCENARIOS["fails-once"]
    swapped = DemoScenario(nominal.name, nominal.title, other.bench, nominal.orders, nominal.expected)
    played = play_on_board(swapped, TOOL, parts, runs / "board-tests" / "swapped", ros=False, figures=False)
    assert [fault.partition(":")[0] for fault in played.faults] == ["attempts", "time-outs"]


def test_a_killed_arbiter_leaves_the_lines_as_they_are(
    parts: Path, runs: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """What no other controller here does: gpio-mxc keeps level and direction, and the next arbiter adopts them."""
    folder = runs / "board-tests" / "kill"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    files = {
        f"opt/{path.relative_to(ROOT)}": path.read_text()
        for path in (
            ROOT / "tests/acceptance/gpiochip/inside/owned.py",
            Path(__file__).with_name("kill_arbiter.py"),
        )
    }
    command = "cd /opt && python3 -m tests.acceptance.board.kill_arbiter"
    ended = run_board(parts, folder, command, files=files, ros=False)
    with capsys.disabled():
        print(f"\nkilled arbiter: {ended.seconds:.0f} s from power-up to power-off; {ended.output}")  # noqa: T201
    assert ended.code == 0, ended.output
    edges = [(edge.line, edge.level) for edge in edges_of(folder / "events")]
    assert sorted(edges[:2]) == [("SODIMM_208", True), ("SODIMM_212", True)]
    assert sorted(edges[2:]) in ([], [("SODIMM_208", False), ("SODIMM_212", False)]), "only at power-off"
