"""Every command with ``--json`` prints objects that name the version of their schema, also when it fails."""

from __future__ import annotations

import json
import signal
from collections.abc import Iterator
from pathlib import Path

import click
import pytest

from end_effector_hal.cli._main import eehal
from end_effector_hal.description import profile_path
from end_effector_hal.wires.lines import VirtualChip
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
    "plugin list": (),
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


# With ``--json`` every error is an object of one shape on stdout, whatever command it comes from.


SHAPE = {"code", "file", "line", "column", "message"}


@pytest.fixture(autouse=True)
def own_signals() -> Iterator[None]:
    """What a command does with signals is over with it."""
    before = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGHUP)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        (("check", "/nowhere.yaml"), "EE-201", "there is no such file"),
        (("verify", "/nowhere.yaml"), "EE-201", "there is no such file"),
        (("verify", "--model", "/nowhere.xml"), "EE-300", "No such file"),
        (("model", "check", "/nowhere.xml"), "EE-300", "No such file"),
        (("model", "show", "/nowhere.yaml"), "EE-201", "there is no such file"),
        (("demo", "--only", "nothing"), "EE-100", "there is no scenario nothing."),
        (("demo", "/nowhere.yaml"), "EE-201", "there is no such file"),
        (("replay", "/nowhere"), "EE-100", "There is no trace here."),
        (("replay",), "EE-100", "Missing argument"),
        (("plot", "/nowhere"), "EE-100", ""),
        (("run", "/nowhere.yaml"), "EE-201", "there is no such file"),
        (("testbench", "/nowhere.yaml"), "EE-201", "there is no such file"),
        (("doctor", "--only", "nothing"), "EE-100", "nothing; there are python,"),
        (("check", "--no-such-option"), "EE-100", "No such option"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, tuple) else "",
)
def test_an_error_is_an_object(
    whole: Whole,
    arguments: tuple[str, ...],
    code: str,
    said: str,
) -> None:
    exit_code, out, err = whole(*arguments, "--json")
    document = json.loads(out)
    assert (exit_code, err) == (2, "")
    assert (document["ok"], document["exit_code"]) == (False, 2)
    (fault,) = document["faults"]
    assert set(fault) == SHAPE
    assert fault["code"] == code
    assert said in fault["message"]


def test_without_it_an_error_is_a_sentence(whole: Whole) -> None:
    exit_code, out, err = whole("replay", "/nowhere")
    assert (exit_code, out) == (2, "")
    assert err.startswith("/nowhere: There is no trace here. Name a folder")


def test_every_fault_of_a_description_is_told(tmp_path: Path, whole: Whole) -> None:
    text = profile_path().read_text(encoding="utf-8")
    path = tmp_path / "tool.yaml"
    path.write_text(text.replace("timeout_s: 5.0", "timeout_s: 5000").replace("attempts: 3", "attempts: 0"))
    told = {}
    for command in ("check", "verify", "demo"):
        _, out, _ = whole(command, str(path), "--json")
        told[command] = json.loads(out)["faults"]
    assert [fault["line"] for fault in told["check"]] == [25, 27]
    assert told["verify"] == told["demo"] == told["check"]


@pytest.mark.parametrize("command", ["verify", "arbiter", "run", "demo", "testbench", "model show"])
def test_what_check_refuses_no_other_command_takes(tmp_path: Path, whole: Whole, command: str) -> None:
    """A codec that carries nothing for an actuator: found where it is read, before anything is done."""
    chip = tmp_path / "chip"
    VirtualChip.create(chip, ["SODIMM_208"])
    text = profile_path().read_text(encoding="utf-8").replace("channel: top", "channel: further")
    path = tmp_path / "tool.yaml"
    path.write_text(text.replace("backend: gpiod", f"backend: virtual\n  path: {chip}"))
    _, _, by_check = whole("check", str(path))
    exit_code, out, err = whole(*command.split(), str(path))
    assert "[EE-225]" in by_check
    sentence = by_check.splitlines(keepends=True)[0]  # below it check shows the line of the file
    assert (exit_code, out, err) == (2, "", sentence)


def test_what_does_not_fit_its_automata_is_not_proven(tmp_path: Path, whole: Whole) -> None:
    text = profile_path().read_text(encoding="utf-8")
    path = tmp_path / "tool.yaml"
    path.write_text(text.replace("bounds:", "automata: {grip: [Griper, Actuator]}\nbounds:"))
    _, checked, _ = whole("check", str(path), "--json")
    exit_code, verified, _ = whole("verify", str(path), "--json")
    assert exit_code == 2
    assert json.loads(verified)["faults"] == json.loads(checked)["faults"]
