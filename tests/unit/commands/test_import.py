"""``eehal import``: what it prints, and its exit codes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.support.bags import frame, state, write_ros1, write_ros2
from tests.unit.conftest import Whole

S = 1_000_000
MESSAGES = [state(S, 0), *frame(0, bottom=-1_000, supply=600_000), state(2 * S, S, 1, count=1)]


@pytest.fixture
def run(whole: Whole, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Whole:
    """Runs a command in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    return whole


def test_a_bag_is_imported_and_drawn(run: Whole, tmp_path: Path) -> None:
    write_ros2(tmp_path / "lift", MESSAGES)
    code, out, err = run("import", "lift", "--profile", "verdin_gripper")
    assert (code, out) == (0, "runs/lift: verdin_gripper, 1.000 s, 2 states, 2 pressures\n")
    assert err == "Note: A bag holds no traces: `eehal replay` cannot judge this run.\n"
    code, out, err = run("plot", "runs/lift", "--json")
    assert (code, json.loads(out)["rows"]) == (0, 2)
    assert (tmp_path / "runs/lift/timeline.png").exists()


def test_a_part_of_a_bag_is_exit_code_1(run: Whole, tmp_path: Path) -> None:
    write_ros1(tmp_path / "lift.bag", [*MESSAGES, state(3 * S, 2 * S, 77)])
    code, out, err = run("import", "lift.bag", "-o", "out")
    assert (code, out) == (1, "out: verdin_gripper, 1.000 s, 2 states, 0 pressures\n")
    assert "Not imported: /EndEffectorState: 1 of 3 messages are left out" in err
    code, out, _ = run("import", "lift.bag", "-o", "again", "--json")
    found = json.loads(out)
    assert (code, found["folder"], found["states"], len(found["faults"])) == (1, "again", 2, 1)


def test_what_is_refused_is_exit_code_2(run: Whole, tmp_path: Path) -> None:
    write_ros1(tmp_path / "lift.bag", MESSAGES)
    assert run("import", "nothing")[0] == 2
    code, out, err = run("import", "lift.bag", "--profile", "verdin_griper")
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    assert run("import", "lift.bag", "--profile", "verdin_gripper", "--description", "x.yaml")[0] == 2
    assert not (tmp_path / "runs").exists()
