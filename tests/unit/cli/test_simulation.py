"""What simulates a tool is found by an entry point, or asked for in one sentence."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from end_effector_hal.cli import main
from end_effector_hal.cli.run import _simulation
from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import MissingExtraError, UsageError
from end_effector_lab.demo import World

TOOL = load(profile_path())


def test_the_workshop_has_it() -> None:
    assert _simulation._SIMULATION.get(_simulation.NAME) is World


def test_without_it_one_sentence_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_simulation, "lab_installed", lambda: False)
    with pytest.raises(MissingExtraError) as refused, _simulation.simulated(TOOL, "nominal"):
        pass
    assert str(refused.value) == (
        "--simulate needs the extra lab, which is not installed. "
        "Install it: pip install '.[lab]' in a checkout of end-effector-hal."
    )
    assert list(_simulation.possible_scenarios(TOOL)) == []


def test_a_scenario_that_the_tool_cannot_have_is_refused_before_anything_is_started(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"no fault is named 'leek'\. Did you mean 'leak'"):
        World(TOOL, "leek:cylinder", tmp_path)
    assert list(tmp_path.iterdir()) == []


def refused(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *options: str) -> str:
    """What `eehal run` says of a usage error."""
    monkeypatch.setattr(sys, "argv", ["eehal", "run", str(profile_path()), *options])
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    return capsys.readouterr().err


def test_what_is_not_simulated_has_no_seed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    said = refused(monkeypatch, capsys, "--seed", "3")
    assert said == "--seed is for a simulated tool: a real one has nothing random. Add --simulate.\n"
    assert "-1 is not in the range" in refused(monkeypatch, capsys, "--simulate", "--seed", "-1")


@pytest.mark.parametrize("options", [("--scenario", "nominal"), ("--script", "lock; scenario supply:300")])
def test_what_is_not_simulated_has_no_scenario(
    options: tuple[str, ...], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert refused(monkeypatch, capsys, *options) == (
        "A scenario is for a simulated tool: nothing makes a real one fail. Add --simulate.\n"
    )
