"""``eehal model fig5``: what is proven, and the run where a tool does something else."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from end_effector_hal.cli.model._check import fig5
from end_effector_hal.description import SHIPPED_AUTOMATA, profile_path

pytestmark = pytest.mark.timeout(300)


def run(*words: str) -> tuple[int, str]:
    result = CliRunner().invoke(fig5, list(words), catch_exceptions=False)
    return result.exit_code, result.stdout


def tool(folder: Path, old: str, new: str) -> str:
    """The shipped description with one edit."""
    text = profile_path().read_text(encoding="utf-8")
    assert old in text
    path = folder / "end_effector.yaml"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    path.with_suffix(".xml").write_bytes(SHIPPED_AUTOMATA.read_bytes())
    return str(path)


def test_the_shipped_tool_does_what_fig_5_does() -> None:
    code, told = run()
    assert code == 0
    assert told.splitlines()[0].startswith("fig5.xml: 15 of 15 requirements hold")
    assert "a grip does nothing that Fig. 5 does not (58 pairs of states)" in told


def test_another_one_does_not_and_a_run_shows_it(tmp_path: Path) -> None:
    path = tool(
        tmp_path,
        "sequence: [bottom_vacuum, cylinder, top_vacuum]",
        "sequence: [bottom_vacuum, cylinder, top_vacuum]\nrelease_order: [cylinder, top_vacuum, bottom_vacuum]",
    )
    code, told = run(path)
    assert code == 4
    assert "a grip does something that Fig. 5 does not" in told
    assert "in the implementation; " in told
    code, told = run(path, "--json")
    document = json.loads(told)
    assert (code, document["included"]) == (4, False)
    assert all(document["fig5"].values())
    assert document["run"]
