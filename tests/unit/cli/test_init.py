"""``eehal init``: what it writes is valid, complete for an editor, and touches nothing."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from end_effector_hal.cli._main import eehal
from end_effector_hal.cli.init import _init
from end_effector_hal.cli.init._init import command
from end_effector_hal.description import load, schema_text
from end_effector_hal.errors import UsageError


def test_a_folder_to_start_from(tmp_path: Path) -> None:
    folder = tmp_path / "my" / "tool"
    result = CliRunner().invoke(command, [str(folder), "--json"], catch_exceptions=False)
    assert result.exit_code == 0
    names = ["end_effector.yaml", "end_effector.schema.json"]
    assert json.loads(result.stdout)["files"] == [str(folder / name) for name in names]
    assert load(folder / "end_effector.yaml").name == "verdin_gripper"
    named = (
        (folder / "end_effector.yaml").read_text(encoding="utf-8").splitlines()[0].partition("$schema=")[2]
    )
    assert (folder / named).read_text(encoding="utf-8") == schema_text()


def test_what_is_there_is_not_touched(tmp_path: Path) -> None:
    (tmp_path / "end_effector.schema.json").write_text("mine")
    result = CliRunner().invoke(command, [str(tmp_path)])
    assert isinstance(result.exception, UsageError)
    assert str(result.exception).startswith(
        f"{tmp_path}/end_effector.schema.json: This file is there already."
    )
    assert [path.name for path in tmp_path.iterdir()] == ["end_effector.schema.json"]


def test_a_link_that_leads_nowhere_is_there_already(tmp_path: Path) -> None:
    elsewhere = tmp_path / "elsewhere.yaml"
    (tmp_path / "tool").mkdir()
    (tmp_path / "tool" / "end_effector.yaml").symlink_to(elsewhere)
    result = CliRunner().invoke(command, [str(tmp_path / "tool")])
    assert isinstance(result.exception, UsageError)
    assert "end_effector.yaml: This file is there already." in str(result.exception)
    assert not elsewhere.exists()


@pytest.mark.parametrize("name", ["file", "file/below"])
def test_what_is_no_folder_is_a_sentence(tmp_path: Path, name: str) -> None:
    (tmp_path / "file").touch()
    result = CliRunner().invoke(command, [str(tmp_path / name)])
    assert isinstance(result.exception, UsageError)
    assert "The folder cannot be made" in str(result.exception)


@pytest.mark.parametrize(
    "arguments", [["init", ""], ["demo", "--no-ros", "-o", ""], ["model", "export", "-o", ""]]
)
def test_an_empty_path_is_not_the_current_folder(
    arguments: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(eehal, arguments)
    assert result.exit_code == 2
    assert "It is empty. Write '.' for the current folder." in result.stderr
    assert list(tmp_path.iterdir()) == []


def test_the_current_folder_is_a_point(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert CliRunner().invoke(eehal, ["init", "."]).exit_code == 0
    assert (tmp_path / "end_effector.yaml").exists()


def test_a_path_with_blanks_is_quoted_in_what_comes_next(tmp_path: Path) -> None:
    result = CliRunner().invoke(eehal, ["init", f"{tmp_path}/my tool"], catch_exceptions=False)
    file = f"'{tmp_path}/my tool/end_effector.yaml'"
    assert f"Next: edit {file}, then `eehal check {file}`." in result.output


@pytest.mark.parametrize("installed", [True, False])
def test_the_extra_of_a_modbus_link_is_named_where_it_is_not_installed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, installed: bool
) -> None:
    monkeypatch.setattr(_init, "find_spec", lambda name: object() if installed else None)
    words = [str(tmp_path / "tool"), "--actuators", "cup:vacuum", "--link", "modbus", "--virtual"]
    result = CliRunner().invoke(command, words, catch_exceptions=False)
    assert result.exit_code == 0
    assert ("needs the extra modbus" in result.output) is not installed
