"""``eehal run`` at a terminal: what a person sees and types; the words, the prompt, an end by Ctrl-C."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from end_effector_hal.description import load, profile_path
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_lab.demo._world import World
from end_effector_lab.processes import EEHAL
from tests.support.terminal import Terminal

pytestmark = [pytest.mark.wall, pytest.mark.timeout(180)]
LONG_S = 60.0
UNTIL_IT_GRIPS = "grip &; wait 1; " * 20
"""A link that was late on a busy machine has a grip refused: it is tried again."""


@pytest.fixture
def world(tmp_path: Path) -> Iterator[World]:
    with World(load(profile_path()), "never-confirms:cylinder", tmp_path) as running:
        yield running


def begin_a_grip(terminal: Terminal) -> int:
    terminal.type("lock\n")
    at = terminal.read_until("LOCK: succeeded")
    while True:
        terminal.type("grip\n")
        at = terminal.read_until(r"STAND_BY -> GRIPPING \(GRIP\)|refused: grip", after=at)
        if "-> GRIPPING" in terminal.text[at - 30 : at]:
            return terminal.read_until("Cylinder PENDING EXTEND", after=at)
        terminal.type("wait 1\n")


def test_ctrl_c_says_what_becomes_of_a_running_grip_and_of_its_outputs(terminal: Terminal) -> None:
    begin_a_grip(terminal)
    terminal.interrupt()
    assert terminal.end() == 130
    last = next(line for line in terminal.text.splitlines() if "GRIP: " in line)
    assert "This process is ending while grip was at work, and does not see its end." in last
    assert "The line arbiter deactivates Cylinder, then Bottom vacuum, as declared." in last


def test_a_cancel_is_in_reach_while_a_grip_runs_and_each_line_has_its_time(terminal: Terminal) -> None:
    at = begin_a_grip(terminal)
    terminal.type("status\ncancel\n")
    at = terminal.read_until(r"verdin_gripper: GRIPPING, executing GRIP\n", after=at)
    terminal.read_until(
        r"\d\.\d{3} s  GRIP: cancelled after \d+\.\d\d s\. The grip was cancelled\.", after=at
    )
    terminal.type("quit\n")
    assert terminal.end() == 1


def test_what_was_typed_is_remembered_in_the_next_session(
    terminal: Terminal, world: World, tmp_path: Path
) -> None:
    terminal.type("drop\n")
    at = terminal.read_until(r"refused: drop\. Nothing is held")
    terminal.type("stat\t\n")
    terminal.read_until("verdin_gripper: STAND_BY", after=at)  # Tab has made it `status`
    terminal.type("quit\n")
    terminal.end()
    home = {"XDG_STATE_HOME": str(tmp_path / "state")}
    with Terminal([*EEHAL, "run", str(world.description_path)], env=home) as later:
        at = later.read_until("OFF -> STAND_BY")
        later.type("\x1b[A\x1b[A\x1b[A\n")  # quit, status, drop
        later.read_until(r"refused: drop\. Nothing is held", after=at)
        later.type("quit\n")
        later.end()


def test_a_time_out_and_a_refusal_are_lines_and_json_has_words_beside_numbers(world: World) -> None:
    script = f"status; lock; {UNTIL_IT_GRIPS}quit"
    command = [*EEHAL, "run", str(world.description_path), "--json", "--script", script]
    timed_out = {"event": "log", "text": "Cylinder was not confirmed within 5 s: attempt 1 of 3."}
    told = []
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for line in process.stdout:
            told.append(json.loads(line))
            if told[-1].items() >= timed_out.items():
                break
        process.terminate()
        process.communicate(timeout=LONG_S)
    assert told[-1].items() >= timed_out.items()
    assert {each["schema_version"] for each in told} == {1}
    status = next(each for each in told if each["event"] == "status")
    assert (status["state"], status["state_name"]) == (EndEffectorState.STAND_BY, "STAND_BY")
    assert (status["actuators"]["cylinder"]["state"], status["actuators"]["cylinder"]["state_name"]) == (
        0,
        "RETRACTED",
    )
    refused = [each["reason"] for each in told if each.get("outcome") == "REJECTED"]
    assert "grip is still running: one goal at a time. Cancel it, or wait for its end." in refused
