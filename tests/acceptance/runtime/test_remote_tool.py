"""Clients of a tool that another process runs: if a client or that process dies, the others find the tool again."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from end_effector_hal.control import Status
from end_effector_hal.control.goals import Outcome
from end_effector_hal.errors import NotReadyError, UsageError
from end_effector_hal.runtime import EndEffector, RemoteTool, RunningGoal
from end_effector_hal.sensing import JudgedReadings
from end_effector_hal.vocabulary import ChangerState, Command, EndEffectorState, Evidence
from end_effector_hal.wires.link import LinkState
from end_effector_lab.demo._world import World
from end_effector_lab.processes import EEHAL, Child
from tests.support.patience import PATIENCE_S, wait_until

pytestmark = [pytest.mark.wall, pytest.mark.timeout(120)]

TOOL = """
schema: 2
name: lit
lines: {backend: gpiod}
link: {port: /dev/ttyUSB0, codec: ees1-ascii}
sequence: [cup, jaw]
actuators:
  cup: {kind: vacuum, line: CUP, channel: bottom}
  jaw: {kind: vacuum, line: JAW, channel: top}
outputs:
  lamp: {line: LAMP}
"""


@pytest.fixture
def hal(world: World) -> Child:
    return serve(world)


@pytest.fixture
def client(world: World, hal: Child) -> Iterator[RemoteTool]:
    assert hal.code is None
    with EndEffector.connect(world.description_path, timeout_s=PATIENCE_S) as tool:
        tool.wait_ready(PATIENCE_S)
        yield tool


def serve(world: World, *options: str) -> Child:
    command = [*EEHAL, "serve", str(world.description_path), *options]
    return world.children.start("hal", command, log=world.folder / "hal.log")


def reached(tool: RemoteTool, state: EndEffectorState) -> None:
    wait_until(state.name, lambda: tool.status.ee == state)


def test_a_client_sees_every_status_once_and_a_result_with_its_evidence(client: RemoteTool) -> None:
    seen: list[Status] = []
    frames: list[int] = []
    client.subscribe(seen.append)
    client.subscribe_frames(lambda frame: frames.append(frame.at))
    result = client.grip()
    assert result.succeeded, result
    assert [step.confirmed for step in result.steps] == [True, True]
    assert client.status.held
    assert client.drop().succeeded
    wait_until("the last status", lambda: bool(seen) and seen[-1].count == client.status.count)
    counts = [each.count for each in seen]
    assert counts == list(range(counts[0], counts[-1] + 1))
    states = [each.ee.name for each in seen]
    assert [now for now, before in zip(states, ["", *states], strict=False) if now != before] == [
        "GRIPPING", "GRIPPED", "RELEASING", "STAND_BY",
    ]  # fmt: skip
    assert frames == sorted(set(frames))
    assert frames


def test_what_one_client_does_another_one_sees_and_is_refused(client: RemoteTool, world: World) -> None:
    goal = client.begin(Command.GRIP)
    assert isinstance(goal, RunningGoal)
    with EndEffector.connect(world.description_path) as other:  # in the middle of a grip
        assert other.status.ee is EndEffectorState.GRIPPING
        refused = other.grip()
        assert refused.outcome is Outcome.REJECTED
        assert goal.wait(PATIENCE_S).succeeded
        reached(other, EndEffectorState.GRIPPED)
        assert other.drop().succeeded
    reached(client, EndEffectorState.STAND_BY)


def test_the_death_of_a_client_ends_no_grip(client: RemoteTool, world: World) -> None:
    command = [*EEHAL, "do", str(world.description_path), "grip"]
    with subprocess.Popen(command) as other:
        reached(client, EndEffectorState.GRIPPING)
        other.kill()
    reached(client, EndEffectorState.GRIPPED)
    assert client.status.held


def test_a_client_whose_hal_dies_says_so_and_finds_the_next_one(
    client: RemoteTool, world: World, hal: Child
) -> None:
    assert client.grip().succeeded
    goal = client.begin(Command.RELEASE)
    assert isinstance(goal, RunningGoal)
    os.kill(hal.pid, signal.SIGKILL)
    result = goal.wait(PATIENCE_S)
    assert result.outcome is Outcome.UNREACHABLE
    assert result.reason.startswith("The HAL has gone: it is unknown whether the command was executed.")
    status = client.status
    assert status.ee is EndEffectorState.OFF
    assert set(status.evidence) == {Evidence.UNKNOWN}
    assert status.changer is ChangerState.UNKNOWN
    assert not status.lift_allowed
    alarm = status.alarm("hal.lost")
    assert alarm is not None
    assert client.grip().outcome is Outcome.REJECTED
    hal.wait_for_end(timeout_s=PATIENCE_S)
    serve(world)
    wait_until("the next HAL", lambda: client.status.ee is not EndEffectorState.OFF)
    assert client.status.alarm("hal.lost") is None
    assert client.drop().outcome in (Outcome.SUCCEEDED, Outcome.REJECTED)
    reached(client, EndEffectorState.STAND_BY)


def test_a_client_has_what_the_sensors_read_and_the_health_of_the_link(
    client: RemoteTool, world: World, hal: Child
) -> None:
    seen: list[JudgedReadings] = []

    def nothing_is_known() -> bool:
        return set(seen[-1].values.values()) == {None}

    client.subscribe_readings(seen.append)
    wait_until("a frame", lambda: seen and "bottom" in seen[-1].sampled)
    assert seen[-1].values["bottom"] == pytest.approx(0, abs=2_000)
    wait_until("health", lambda: client.sensors.links)
    (link,) = client.sensors.links.values()
    assert link.state is LinkState.UP
    assert link.frames > 0
    world.choose("silent-after:0")
    wait_until("silence", nothing_is_known)
    assert seen[-1].sampled == ()
    world.choose("nominal")
    wait_until("frames again", lambda: not nothing_is_known())
    os.kill(hal.pid, signal.SIGKILL)
    wait_until("the loss", lambda: nothing_is_known() and not client.sensors.links)


def test_a_hal_that_is_stopped_is_silent_until_it_goes_on(client: RemoteTool, hal: Child) -> None:
    assert client.grip().succeeded
    os.kill(hal.pid, signal.SIGSTOP)
    try:
        wait_until("silence", lambda: client.status.alarm("hal.lost") is not None)
        assert client.status.held  # as last known
        assert not client.status.lift_allowed
    finally:
        os.kill(hal.pid, signal.SIGCONT)
    wait_until("a sign of life", lambda: client.status.alarm("hal.lost") is None)


def test_outputs_actuators_stop_and_reset_of_another_process(client: RemoteTool) -> None:
    assert client.outputs == {"lamp": False}
    assert client.set_output("lamp", True).accepted
    assert client.outputs == {"lamp": True}
    with pytest.raises(UsageError, match="is no output of lit"):
        client.set_output("lmap", True)
    moved = client.set_actuator("jaw", True)
    assert moved.accepted, moved
    assert moved.reason == "Jaw is active, proven by its sensor."
    assert client.set_actuator("jaw", False).accepted
    assert client.stop().accepted
    wait_until("the stop", lambda: client.status.alarm("arbiter.stopped") is not None)
    assert client.grip().outcome is Outcome.REJECTED
    reset = client.reset()
    assert reset.accepted, reset
    assert client.grip().succeeded


def test_without_a_hal_or_with_another_description(world: World, tmp_path: Path) -> None:
    with pytest.raises(NotReadyError, match="lit cannot be reached: The HAL does not run") as none:
        EndEffector.connect(world.description_path, timeout_s=0.5)
    assert f"eehal serve {world.description_path}" in str(none.value)
    serve(world)
    with EndEffector.connect(world.description_path, timeout_s=PATIENCE_S):
        pass
    text = world.description_path.read_text(encoding="utf-8")
    changed = world.description_path.with_name("changed.yaml")
    changed.write_text(text.replace("sequence: [cup, jaw]", "sequence: [jaw, cup]"), encoding="utf-8")
    assert changed.read_text(encoding="utf-8") != text
    with pytest.raises(NotReadyError, match="The HAL runs another description"):
        EndEffector.connect(changed, timeout_s=1.0)


def test_the_end_of_the_service_does_what_the_description_declares(
    client: RemoteTool, world: World, hal: Child
) -> None:
    assert client.grip().succeeded
    os.kill(hal.pid, signal.SIGTERM)
    assert hal.wait_for_end(timeout_s=PATIENCE_S) == 0
    said = (world.folder / "hal.log").read_text(encoding="utf-8")
    assert "GRIPPING -> GRIPPED" in said
    assert said.splitlines()[-1].startswith("Cup")
    lines = serve(world, "--json")
    wait_until("the next HAL", lambda: client.status.ee is not EndEffectorState.OFF)
    assert json.loads(lines.text().splitlines()[-1])["schema_version"] == 1
    os.kill(lines.pid, signal.SIGTERM)
    lines.wait_for_end(timeout_s=PATIENCE_S)
    wait_until("the end", lambda: client.status.alarm("hal.lost") is not None)


def test_status_and_do_on_the_command_line(client: RemoteTool, world: World) -> None:
    def eehal(*words: str) -> subprocess.CompletedProcess[str]:
        command = [*EEHAL, words[0], str(world.description_path), *words[1:]]
        return subprocess.run(command, capture_output=True, text=True, check=False, timeout=PATIENCE_S)

    first, *_ = map(json.loads, eehal("do", "--json", "grip").stdout.splitlines())
    assert next(iter(first.items())) == ("schema_version", 1)
    (told,) = map(json.loads, eehal("status", "--json").stdout.splitlines())
    assert next(iter(told.items())) == ("schema_version", 1)
    assert told["state_name"] == "GRIPPED"
    shown = eehal("status")
    assert shown.returncode == 0
    for more in ([], ["--json"]):
        command = [*EEHAL, "status", str(world.description_path), *more]
        with Path("/dev/full").open("w") as full:
            done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
        assert (done.returncode, done.stderr) == (
            2,
            "The output cannot be written: No space left on device.\n",
        )
    assert shown.stdout.startswith("lit: GRIPPED; a part is held, lift allowed\n")
    again = eehal("do", "grip")
    assert again.returncode == 1
    assert "refused: grip." in again.stdout
    assert client.status.ee is EndEffectorState.GRIPPED
    interrupted = subprocess.Popen(
        [*EEHAL, "do", str(world.description_path), "drop; wait 60"], stdout=subprocess.PIPE, text=True
    )
    reached(client, EndEffectorState.STAND_BY)
    time.sleep(0.5)
    interrupted.send_signal(signal.SIGINT)
    out, _ = interrupted.communicate(timeout=PATIENCE_S)
    assert "DROP: succeeded" in out
    assert "Traceback" not in out


def test_a_process_of_its_own_records_what_the_tool_does(
    client: RemoteTool, world: World, tmp_path: Path
) -> None:
    folder = tmp_path / "kept" / "run"
    own = ["sh", "-c", 'exec "$@" > /dev/full', "sh"]  # what it prints is not what it is for
    command = [*own, *EEHAL, "record", str(world.description_path), str(folder)]
    recorder = world.children.start("recorder", command, log=tmp_path / "recorder.log")
    states = folder / "states.csv"

    def recorded() -> list[int]:
        rows = states.read_text().splitlines()[1:] if states.exists() else []
        return [int(row.split(",")[1]) for row in rows]

    wait_until("the state at its start", lambda: recorded() == [EndEffectorState.STAND_BY])
    assert client.grip().outcome is Outcome.SUCCEEDED
    wait_until("the grip", lambda: recorded()[-1] == EndEffectorState.GRIPPED)
    os.kill(recorder.pid, signal.SIGTERM)
    wait_until("its end", lambda: recorder.code is not None)
    assert recorder.code == 0
    assert client.status.ee is EndEffectorState.GRIPPED, "the end of the recorder touches nothing"
