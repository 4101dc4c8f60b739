"""The command on a changed description."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from end_effector_hal.cli import _check
from tests.unit.cli.check.shipped import SHIPPED, Check


@pytest.fixture
def check(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Check:
    """Runs the command on the shipped description with a text replaced in it."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")

    def run(*options: str, replace: dict[str, str] | None = None) -> Result:
        text = SHIPPED
        for old, new in (replace or {}).items():
            assert text.count(old) == 1, old
            text = text.replace(old, new)
        Path("tool.yaml").write_text(text, encoding="utf-8")
        return CliRunner().invoke(_check.command, ["tool.yaml", *options], catch_exceptions=False)

    return run
