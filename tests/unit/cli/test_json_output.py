"""Every command with ``--json`` prints objects that name the version of their schema, also when it fails."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import click
import pytest

from end_effector_hal.cli._main import eehal
from end_effector_hal.description import profile_path
from tests.unit.cli.test_model import LAMP
from tests.unit.conftest import Whole

ELSEWHERE = {
    "run": "tests/acceptance/cli/test_run_on_a_terminal.py",
    **dict.fromkeys(("do", "serve", "status"), "tests/acceptance/runtime/test_remote_tool.py"),
    "listen": "tests/unit/cli/test_listen.py",
    "report": "tests/unit/page/test_recorded.py",
    "demo": "tests/unit/demo/test_demo.py",
    "testbench": "tests/acceptance/testbench/test_program.py",
    "import": "tests/unit/commands/test_import.py",
    "campaign": "tests/unit/trials/test_campaign.py",
    "matrix": "tests/unit/trials/test_grid.py",
}
CALLS: dict[str, tuple[str, ...]] = {
    "check": (),
    "compare": ("nothing", "nothing"),
    "devices": (),
    "doctor": ("--only", "python"),
    "history": (str(profile_path()),),
    "init": ("new",),
    "model check": (),
    "model fig5": (),
    "model show": ("--model", "lamp.xml"),
    "model simulate": ("--steps", "30"),
    "plot": ("nothing",),
    "reload": (str(profile_path()),),
    "replay": ("nothing",),
    "reset": (str(profile_path()),),
    "stop": (str(profile_path()),),
    "tune": ("nothing",),
    "verify": ("--model", "lamp.xml"),
}


def with_json(group: click.Group = eehal, before: str = "") -> Iterator[str]:
    context = click.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        if isinstance(command, click.Group):
            yield from with_json(command, f"{name} ")
        elif command is not None and any("--json" in parameter.opts for parameter in command.params):
            yield before + name


def test_each_command_with_json_is_known_here() -> None:
    assert set(with_json()) - ELSEWHERE.keys() == CALLS.keys()


def called(whole: Whole, *arguments: str) -> dict[str, object]:
    answer: dict[str, object] = json.loads(whole(*arguments)[1])
    return answer


@pytest.mark.parametrize("name", CALLS)
def test_its_object_names_the_version_first(
    name: str, monkeypatch: pytest.MonkeyPatch, whole: Whole, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lamp.xml").write_text(LAMP)
    answer = called(whole, *name.split(), *CALLS[name], "--json")
    assert next(iter(answer.items())) == ("schema_version", 1)


def test_a_run_of_the_model_has_words_beside_its_numbers(whole: Whole) -> None:
    choose = "world == IN_TIME; adopt; grip @ 1000"
    answer = called(whole, "model", "simulate", str(profile_path()), "--choose", choose, "--json")
    steps = answer["steps"]
    assert isinstance(steps, list)
    gripping = next(step for step in steps if step["changes"].get("ee") == [6, 1])
    assert gripping["words"]["ee"] == ["STAND_BY", "GRIPPING"]
    pending = next(step for step in steps if "actuator[0]" in step["changes"])
    assert pending["words"]["actuator[0]"] == ["OFF", "PENDING ON"]
    assert all(set(step["words"]) <= set(step["changes"]) for step in steps)
