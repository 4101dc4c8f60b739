"""``eehal arbiter`` drives the tool that it is told to, and none by default."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from end_effector_hal.cli._arbiter import arbiter
from end_effector_hal.description import profile_path, tool_path
from end_effector_hal.errors import UsageError

HOW = "DESCRIPTION or --profile NAME"


def test_without_a_tool_it_drives_none() -> None:
    ended = CliRunner().invoke(arbiter, [])
    assert str(ended.exception) == (
        "No tool is named: exactly one tool is needed. Give DESCRIPTION or --profile NAME; "
        "shipped profiles: verdin_gripper."
    )


def test_two_tools_are_one_too_many() -> None:
    ended = CliRunner().invoke(arbiter, ["tool.yaml", "--profile", "verdin_gripper"])
    assert str(ended.exception).startswith("Two tools are named: exactly one tool is needed.")


def test_a_profile_is_named_instead(monkeypatch: pytest.MonkeyPatch) -> None:
    driven: list[Path] = []
    monkeypatch.setattr(
        "end_effector_hal.arbiter.run_arbiter", lambda description, *_: driven.append(description.source)
    )
    assert CliRunner().invoke(arbiter, ["--profile", "verdin_gripper"]).exit_code == 0
    assert driven == [profile_path()]


def test_a_path_becomes_absolute_where_it_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", "/home/me")
    assert tool_path("tool.yaml", "", how=HOW) == tmp_path / "tool.yaml"
    assert tool_path("~/tool.yaml", "", how=HOW) == Path("/home/me/tool.yaml")
    assert tool_path("", "verdin_gripper", how=HOW) == profile_path()
    with pytest.raises(UsageError, match="no profile is named 'verdin_griper'"):
        tool_path("", "verdin_griper", how=HOW)
