"""``eehal run`` as a program: what it prints, how it ends, and a tool that does not get ready."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from pathlib import Path

import pytest

from end_effector_hal.arbiter import ArbiterClient
from end_effector_hal.description import profile_path
from end_effector_hal.errors import NotReadyError
from end_effector_hal.runtime import EndEffector
from end_effector_lab.demo._world import World
from end_effector_lab.processes import EEHAL
from tests.support.patience import wait_until

pytestmark = [pytest.mark.wall, pytest.mark.timeout(180)]
LONG_S = 60.0


def clients(world: World) -> list[str]:
    with ArbiterClient(world.socket, "look") as look:
        return [each["client"] for each in look.status()["clients"]]


def test_json_lines_then_sigterm_ends_in_order(world: World, tmp_path: Path) -> None:
    script = "lock; grip; arm; wait 600"
    command = [*EEHAL, "run", str(world.description_path), "--json", "--script", script]
    record, errors = tmp_path / "recorded", tmp_path / "errors"
    with errors.open("w") as err:
        process = subprocess.Popen(
            [*command, "--record", str(record)], stdout=subprocess.PIPE, stderr=err, text=True
        )
        assert process.stdout is not None
        told = []
        for line in process.stdout:
            told.append(json.loads(line))
            if told[-1].get("command") == "ARM":
                break
        process.send_signal(signal.SIGTERM)
        assert process.wait(LONG_S) == 128 + signal.SIGTERM
        process.stdout.close()
    # whether a grip succeeds on a busy machine is not asked here
    results = {each["command"]: each for each in told if each["event"] == "result"}
    assert list(results) == ["LOCK", "GRIP", "ARM"]
    assert [step["name"] for step in results["GRIP"]["steps"]] in ([], list(world.description.sequence))
    assert results["ARM"]["reason"]
    states = [each for each in told if each["event"] == "state"]
    assert states[0]["end_effector"] == "OFF"
    assert list(states[0]["actuators"]) == list(world.description.sequence)
    assert errors.read_text() == ""
    # it left the arbiter with its will, as the description declares, and did not die
    wait_until("it leaves", lambda: clients(world) == [])
    assert "its socket was closed" not in (tmp_path / "arbiter.log").read_text()
    assert (record / "states.csv").read_text().count("\n") > 1


def test_a_tool_without_its_link_is_not_ready_and_says_why(world: World) -> None:
    os.kill(world.testbench.pid, signal.SIGSTOP)
    try:
        with EndEffector.open(world.description) as tool:
            with pytest.raises(NotReadyError) as refused:
                tool.wait_ready(3.0)
            assert isinstance(refused.value, TimeoutError)
            said = str(refused.value)
            assert said.startswith("verdin_gripper is not ready after 3 s: ")
            assert f"sensor link {world.port}" in said
            assert "its sensors do not show whether the tool is locked" in said
            assert said.endswith("eehal doctor prints what is missing.")
            os.kill(world.testbench.pid, signal.SIGCONT)
            tool.wait_ready(LONG_S)
            assert tool.lock().succeeded
    finally:
        os.kill(world.testbench.pid, signal.SIGCONT)


def test_a_folder_that_cannot_be_written_is_told_once(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    command = [
        *EEHAL,
        "run",
        str(profile_path()),
        "--script",
        "lock",
        "--record",
        str(tmp_path / "file" / "x"),
    ]
    result = subprocess.run(command, capture_output=True, text=True, timeout=LONG_S, check=False)
    assert (result.returncode, result.stdout) == (2, "")
    assert result.stderr == (
        f"{tmp_path}/file/x: The recording cannot be written: Not a directory. Name another folder.\n"
    )


def test_a_second_run_never_writes_into_the_recording_of_the_first(world: World, tmp_path: Path) -> None:
    folder, told = tmp_path / "recorded", []
    for script in ("lock", "lock; grip; drop", "lock"):
        command = [*EEHAL, "run", str(world.description_path), "--script", script, "--record", str(folder)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=LONG_S, check=False)
        told.append(done.stderr)
        if len(told) == 1:
            first = {each.name: each.read_bytes() for each in folder.iterdir()}
    assert {each.name: each.read_bytes() for each in folder.iterdir()} == first
    for number in (2, 3):
        own = tmp_path / f"recorded-{number}"
        assert f"{folder} holds a recording already: this run is recorded into {own}.\n" in told[number - 1]
        assert (own / "run.json").exists()
        assert (own / "states.csv").read_text().count("\n") > 1
