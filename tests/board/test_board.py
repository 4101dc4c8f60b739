"""The paper's scenarios on the emulated Verdin: its device tree, its GPIO controller, its UART, arm64 ROS of Debian."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from emulated import HOME, Ended, run_board
from seen import edges_of

from end_effector_hal.demo import judge, scenarios
from end_effector_hal.demo._pictures import draw
from end_effector_hal.demo._world import EEHAL
from end_effector_hal.description import load, profile_path
from end_effector_hal.trace import read_run, read_states

HERE = Path(__file__).parent
RUNS = HERE.parents[1] / "runs" / "board"
TOOL = load(profile_path())


def fresh(name: str) -> Path:
    folder = RUNS / name
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder


def said(ended: Ended, capsys: pytest.CaptureFixture[str]) -> str:
    with capsys.disabled():
        print(f"\n{ended.seconds:.0f} s from power-up to power-off")  # noqa: T201 asked for
    return ended.output


@pytest.mark.parametrize("name", ["nominal", "fails-once", "never-confirms"])
def test_a_scenario_on_the_board(
    parts: Path, place: Path, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """The shipped description, unchanged: its line names are found on gpio-mxc, its port is the board's."""
    (scenario,) = (each for each in scenarios(TOOL) if each.name == name)
    folder = fresh(name)
    bench = [*EEHAL, "testbench", "--scenario", scenario.bench, "--events", str(folder / "events")]
    job = f"eehal doctor --only lines; eehal demo --own-wires --no-figures --only {name} -o /run/results"
    ended = run_board(parts, folder, place, job, bench)
    output = said(ended, capsys)
    assert ended.code in (0, 1), output  # 1: a time-out came later than 100 ms, as it may on an emulator
    for line in ("SODIMM_206 = /dev/gpiochip0 line 0", "SODIMM_212 = /dev/gpiochip0 line 6"):
        assert line in output
    recorded = folder / "results" / name
    log, info = read_states(recorded / "states.csv"), read_run(recorded)
    draw(recorded, log, info)
    report = judge(scenario, TOOL, log, info, edges_of(folder / "events"))
    assert [str(finding) for finding in report.findings if not finding.ok] == []


def test_a_killed_owner_leaves_the_lines_as_they_are(
    parts: Path, place: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """What no other controller here does: gpio-mxc keeps level and direction, and the next owner adopts them."""
    folder = fresh("kill")
    inside = HERE.parent / "gpiochip" / "inside" / "owned.py"
    files = {
        f"{HOME}/site/owned.py": inside.read_text(),
        f"{HOME}/kill_owner.py": (HERE / "kill_owner.py").read_text(),
    }
    bench = [*EEHAL, "testbench", "--events", str(folder / "events")]
    ended = run_board(parts, folder, place, f"python3 /{HOME}/kill_owner.py", bench, files=files)
    output = said(ended, capsys)
    assert ended.code == 0, output
    edges = [(edge.line, edge.level) for edge in edges_of(folder / "events")]
    assert sorted(edges[:2]) == [("SODIMM_208", True), ("SODIMM_212", True)]
    assert sorted(edges[2:]) in ([], [("SODIMM_208", False), ("SODIMM_212", False)]), "only at power-off"
