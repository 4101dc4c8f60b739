"""``eehal doctor`` on real parts: a virtual chip, a pty, a line arbiter, and on machines that lack them."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from click.testing import CliRunner

from end_effector_hal.cli.doctor import _doctor, _machine, _ros
from end_effector_hal.cli.doctor._check_result import CheckResult, Level
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.wires import holders_of
from end_effector_hal.wires.lines import read_chip
from end_effector_lab.demo._world import World
from tests.unit.cli.doctor.parts import Machine


@pytest.mark.wall
@pytest.mark.timeout(90)
def test_a_running_tool_is_well(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ROS_MASTER_URI", raising=False)
    with World(load(profile_path()), "nominal", tmp_path) as world:
        arguments = [str(world.description_path), "--json"]
        result = CliRunner().invoke(_doctor.command, arguments, catch_exceptions=False)
        told = json.loads(result.stdout)
        assert (result.exit_code, told["ok"], told["exit_code"]) == (0, True, 0), result.stdout
        of: dict[str, list[dict[str, str]]] = {}
        for each in told["findings"]:
            of.setdefault(each["part"], []).append(each)
        assert list(of) == list(_doctor.PARTS)
        (lines,), (arbiter, active), (link,) = of["lines"], of["arbiter"], of["link"]
        assert lines["what"].endswith(
            f"active: none; held by pid {world_arbiter(world)} ({arbiter_words(world)})"
        )
        assert arbiter["what"] == f"pid {world_arbiter(world)} serves {world.socket}; no program writes"
        assert active["what"] == "active: no line"
        assert link["what"].startswith(f"{world.port}, ees1-ascii, 115200 baud: 50 frames, ")
        assert 35 <= int(link["what"].split(", ")[-1].split()[0]) <= 60
        assert [each["status"] for each in (*of["lines"], *of["arbiter"], *of["link"])] == ["ok"] * 4
        # nothing was requested: the lines are as the arbiter adopted them
        assert set(read_chip(world.chip).lines.values()) == {("out", False)}


def world_arbiter(world: World) -> int:
    (holder,) = holders_of(f"{world.chip}.lock")
    return holder.pid


def arbiter_words(world: World) -> str:
    return holders_of(f"{world.chip}.lock")[0].program


def test_nothing_is_there(machine: Machine) -> None:
    result = machine.doctor()
    assert result.exit_code == 3
    lines = result.stdout.splitlines()
    missing = [line.split(maxsplit=2) for line in lines if line.startswith("missing")]
    assert [words[1] for words in missing] == ["lines", "arbiter", "link"]
    assert missing[0][2] == f"{machine.chip}: there is no virtual chip: No such file or directory."
    assert missing[1][2] == f"no line arbiter runs at {machine.socket}"
    assert missing[2][2] == f"{machine.port} does not exist"
    assert all(lines[i + 1].strip().startswith("→ ") for i, line in enumerate(lines) if line[:7] == "missing")
    assert sorted(path.name for path in machine.path.parent.iterdir()) == ["tool.yaml"]


@pytest.mark.parametrize("text", ["", "name: [", "\0", "name: x\nlink: {port: /dev/null}\n"])
def test_a_bad_description_is_2_and_the_rest_is_looked_at(machine: Machine, text: str) -> None:
    machine.path.write_text(text)
    result = machine.doctor("--json")
    told = json.loads(result.stdout)
    assert (result.exit_code, told["exit_code"]) == (2, 2)
    parts = [each["part"] for each in told["findings"]]
    assert set(parts) == {"python", "description", "ros", "machine"}
    assert all(
        str(machine.path) in each["what"] for each in told["findings"] if each["part"] == "description"
    )


def test_a_description_is_a_file(tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "none.yaml"):
        assert CliRunner().invoke(_doctor.command, [str(path)], catch_exceptions=False).exit_code == 2


def test_what_does_not_fit_the_codec_is_told(machine: Machine) -> None:
    machine.describe("ees1-asci")
    ((level, what, _),) = machine.findings("description")
    assert (level, "there is no such codec" in what, "did you mean" in what) == ("missing", True, True)


def test_only_what_was_asked_for(machine: Machine) -> None:
    machine.make_chip()
    result = machine.doctor("--only", "lines, machine")
    assert result.exit_code == 0
    assert {line.split()[1] for line in result.stdout.splitlines() if line[:1].isalpha()} == {
        "lines",
        "machine",
    }
    refused = CliRunner().invoke(_doctor.command, [str(machine.path), "--only", "line"])
    assert (refused.exit_code, "there are python, description, ros" in refused.output) == (2, True)


def test_never_a_traceback(machine: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    def breaks() -> Iterator[CheckResult]:
        raise ZeroDivisionError

    monkeypatch.setattr(_ros, "look_at_ros", breaks)
    assert machine.finding("ros") == (
        "missing",
        "it could not be looked at: ZeroDivisionError: no reason given",
        "Please report this.",
    )


def test_hints_about_time() -> None:
    def told(finding: CheckResult) -> tuple[Level, str]:
        return finding.level, finding.what

    assert told(_machine.kernel("#1 SMP PREEMPT_DYNAMIC x", realtime=False))[0] is Level.OK
    assert told(_machine.kernel("#1 SMP PREEMPT_RT x", realtime=False)) == (
        Level.OK,
        "kernel with PREEMPT_RT",
    )
    assert told(_machine.kernel("#1 SMP x", realtime=False))[0] is Level.WARNING
    assert told(_machine.load(2.0, 2)) == (Level.OK, "load 2.0 on 2 processors")
    assert told(_machine.load(1.1, 1))[0] is Level.WARNING
    assert told(_machine.lateness(25_000, 50_000))[0] is Level.OK
    assert told(_machine.lateness(25_001, 50_000))[0] is Level.WARNING
    assert told(_machine.lateness(99_000, None))[0] is Level.OK


def test_the_reaction_bound_is_that_of_the_description(
    machine: Machine, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_machine, "worst_wake_up_us", lambda: 7_000)
    text = machine.path.read_text()
    machine.describe(text=text.replace("reaction_ms: 50", "reaction_ms: 10"))
    assert machine.findings("machine")[-1][:2] == (
        "warning",
        "worst of 50 wake-ups 7.0 ms late; the reaction bound is 10 ms",
    )


def test_the_shipped_description_is_the_default() -> None:
    result = CliRunner().invoke(_doctor.command, ["--only", "description"], catch_exceptions=False)
    description: Description = load(profile_path())
    assert result.stdout == (
        f"ok       description  {profile_path()}: {description.name} ({description.fingerprint()})\n"
    )
