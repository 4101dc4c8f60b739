"""With ``--json`` every error is an object of one shape on stdout, whatever command it comes from."""

from __future__ import annotations

import json
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from end_effector_hal.description import profile_path
from end_effector_hal.wires.lines import VirtualChip
from tests.unit.conftest import Whole

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
