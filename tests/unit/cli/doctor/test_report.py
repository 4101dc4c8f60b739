"""``eehal doctor --report``: one file for a bug report, and nothing in it that concerns nobody else."""

from __future__ import annotations

import json
import platform
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from end_effector_hal.cli._main import eehal
from end_effector_hal.cli.doctor._report import without_secrets
from end_effector_hal.description import profile_path
from end_effector_hal.errors import UsageError

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
