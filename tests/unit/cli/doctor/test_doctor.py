"""``eehal doctor`` on real parts, on machines that lack them, and its report for a bug."""

from __future__ import annotations

import json
import platform
from collections.abc import Iterator
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from end_effector_hal.cli._main import eehal
from end_effector_hal.cli.doctor import _doctor, _machine, _ros
from end_effector_hal.cli.doctor._check_result import CheckResult, Level
from end_effector_hal.cli.doctor._report import without_secrets
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.errors import UsageError
from end_effector_hal.wires import holders_of
from end_effector_hal.wires.lines import read_chip
from end_effector_lab.demo._world import World
from tests.unit.cli.doctor.conftest import Machine


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


# ``eehal doctor --report``: one file for a bug report, and nothing in it that concerns nobody else.


SECRET = "hunter2hunter2"


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    home = tmp_path / "houses" / "alice"
    home.mkdir(parents=True)
    for name, value in (("HOME", str(home)), ("LOGNAME", "alice"), ("USER", "alice"), ("MY_TOKEN", SECRET)):
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(platform, "node", lambda: "robot7")
    return home


def report(home: Path, name: str) -> tuple[Result, str]:
    tool = home / "tool.yaml"
    secrets = f"# token: {SECRET}\n# ask alice on robot7, http://bob:{SECRET}@example.org/x\n"
    tool.write_text(secrets + profile_path().read_text() + f"# password={SECRET}")
    file = home / name
    result = CliRunner().invoke(
        eehal, ["doctor", str(tool), "--only", "python,description", "--report", str(file)]
    )
    return result, file.read_text()


def test_it_has_what_was_found_the_versions_and_the_description_without_secrets(home: Path) -> None:
    result, text = report(home, "report.txt")
    assert "end-effector-hal: " in text
    assert "ok       description  ~/tool.yaml: verdin_gripper" in text
    assert "click: " in text
    assert "sequence: [bottom_vacuum, cylinder, top_vacuum]" in text
    for private in (SECRET, "alice", "robot7", str(home)):
        assert private not in text
    assert "ask <user> on <host>, http://example.org/x" in text
    assert "report.txt: look through it before you pass it on." in result.stderr
    assert result.exit_code in (0, 3)


def test_it_replaces_no_description(home: Path) -> None:
    tool = home / "tool.yaml"
    tool.write_bytes(profile_path().read_bytes())
    with pytest.raises(UsageError, match=r"eehal doctor \S+/tool\.yaml --report report\.txt"):
        CliRunner().invoke(eehal, ["doctor", "--report", str(tool)], catch_exceptions=False)
    assert tool.read_bytes() == profile_path().read_bytes()


def test_as_json_it_has_the_same(home: Path) -> None:
    _, text = report(home, "report.json")
    told = json.loads(text)
    assert told["schema_version"] == 1
    assert {each["part"] for each in told["findings"]} == {"python", "description"}
    assert "click" in told["packages"]
    assert SECRET not in text


def test_a_file_that_cannot_be_written_is_a_sentence(tmp_path: Path) -> None:
    result = CliRunner().invoke(
        eehal, ["doctor", "--only", "python", "--report", str(tmp_path / "no" / "x.txt")]
    )
    assert "The file cannot be written: No such file or directory." in str(result.exception)


def test_words_that_only_contain_a_name_stay(home: Path) -> None:
    assert without_secrets("alices robot77 /home/bob/x") == "alices robot77 ~/x"


def test_paths_of_the_people_are_shortened_and_those_of_the_system_stay(
    home: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    elsewhere = tmp_path / "customer-x" / "src"
    elsewhere.mkdir(parents=True)
    monkeypatch.setenv("PYTHONPATH", f"{elsewhere}:/opt/ros/jazzy/lib")
    _, text = report(home, "report.txt")
    assert "PYTHONPATH: …/src:/opt/ros/jazzy/lib" in text
    assert "customer-x" not in text
    assert "/dev/verdin-uart1" in text
    assert without_secrets("/arm/SetToolChanger, https://example.org/tmp/x") == (
        "/arm/SetToolChanger, https://example.org/tmp/x"
    )
