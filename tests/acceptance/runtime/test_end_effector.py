"""A whole tool without ROS: real line arbiter, real testbench, real pty; what is killed is really killed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest

from end_effector_hal.arbiter import ArbiterClient
from end_effector_hal.control import Status
from end_effector_hal.description import load, profile_path
from end_effector_hal.runtime import EndEffector
from end_effector_hal.vocabulary import EndEffectorState, Evidence
from end_effector_hal.wires.lines import read_chip
from end_effector_lab.demo._world import World
from end_effector_lab.processes import EEHAL
from tests.support.declared import declared
from tests.support.patience import PATIENCE_S, wait_until

pytestmark = [pytest.mark.wall, pytest.mark.timeout(90)]

GRIPPING_LINES = ("SODIMM_208", "SODIMM_210", "SODIMM_212")
ALL_ACTIVE = dict.fromkeys(GRIPPING_LINES, True)
NONE_ACTIVE = dict.fromkeys(GRIPPING_LINES, False)

HOLDER = """
import sys, time
from end_effector_hal.runtime import EndEffector
from end_effector_lab.processes import EEHAL
tool = EndEffector.open(sys.argv[1])
tool.wait_ready(30.0)
print("adopted", flush=True)
if "grip" in sys.argv:
    print(tool.grip().state.name, flush=True)
while "by hand" in sys.argv and not tool.set_actuator("cylinder", True).accepted:
    time.sleep(0.1)
time.sleep(600)
"""


@pytest.fixture(scope="module")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Iterator[World]:
    with World(load(profile_path()), "nominal", tmp_path_factory.mktemp("world")) as running:
        yield running


@pytest.fixture
def world(shared: World) -> World:
    """Nothing is active, and nothing wrong at the testbench."""
    shared.choose("nominal")
    wait_until("rest", lambda: levels(shared) == NONE_ACTIVE)
    return shared


def levels(world: World) -> dict[str, bool]:
    state = read_chip(world.chip)
    return {line: bool(state.lines[line].level) for line in GRIPPING_LINES}


def holder(world: World, *arguments: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-c", HOLDER, str(world.description_path), *arguments]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    assert process.stdout.readline().strip() == "adopted"
    return process


def kill(process: subprocess.Popen[str]) -> None:
    process.kill()
    process.wait()
    if process.stdout:
        process.stdout.close()


def test_grip_and_drop_by_hand_and_in_order(world: World) -> None:
    with EndEffector.open(world.description) as tool:
        tool.wait_ready(30.0)
        wait_until("it", lambda: tool.set_actuator("cylinder", True).accepted)
        assert "IL-12" in tool.grip().reason
        assert tool.set_actuator("cylinder", False).accepted
        wait_until("it", lambda: tool.lock().succeeded)
        wait_until("it is retracted", lambda: set(tool.status.evidence) == {Evidence.GONE})
        result = tool.grip()
        assert (result.succeeded, result.state) == (True, EndEffectorState.GRIPPED), result.reason
        assert [step.attempts for step in result.steps] == [1, 1, 1]
        assert levels(world) == ALL_ACTIVE
        assert not tool.unlock().succeeded
        assert tool.drop().succeeded
        assert levels(world) == NONE_ACTIVE


def test_the_death_of_the_program_ends_what_was_driven_by_hand(world: World) -> None:
    process = holder(world, "by hand")
    wait_until("it", lambda: levels(world)["SODIMM_210"])
    kill(process)
    wait_until("it", lambda: levels(world) == NONE_ACTIVE)


def test_the_death_of_the_arbiter_moves_no_line_and_ends_no_grip(world: World, tmp_path: Path) -> None:
    with EndEffector.open(world.description) as tool:
        tool.wait_ready(30.0)
        wait_until("it", lambda: tool.grip().succeeded)
        with ArbiterClient(world.socket, "test") as observer:
            os.kill(observer.status()["pid"], signal.SIGKILL)
        time.sleep(0.5)
        assert levels(world) == ALL_ACTIVE
        again = world.children.start(
            "line arbiter again", [*EEHAL, "arbiter", str(world.description_path)], log=tmp_path / "again.log"
        )
        again.wait_until(lambda: "ready:" in again.text(), timeout_s=PATIENCE_S, what="it was ready")
        assert levels(world) == ALL_ACTIVE
        assert tool.status.ee == EndEffectorState.GRIPPED
        wait_until("it", lambda: tool.drop().succeeded)
        assert levels(world) == NONE_ACTIVE


def test_the_death_of_the_program_while_gripped_holds_and_is_adopted(world: World) -> None:
    process = holder(world, "grip")
    assert process.stdout is not None
    assert process.stdout.readline().strip() == "GRIPPED"
    kill(process)
    time.sleep(1.5)
    assert levels(world) == ALL_ACTIVE
    with EndEffector.open(world.description) as tool:
        tool.wait_ready(30.0)
        assert tool.status.ee == EndEffectorState.GRIPPED
        assert tool.drop().succeeded


def test_the_death_of_the_program_while_gripping_unwinds_in_reverse(world: World) -> None:
    world.choose("never-confirms:top_vacuum")
    process = holder(world, "grip")
    wait_until("it", lambda: levels(world) == ALL_ACTIVE)
    kill(process)
    seen = [ALL_ACTIVE]

    def all_inactive() -> bool:
        if levels(world) != seen[-1]:
            seen.append(levels(world))
        return seen[-1] == NONE_ACTIVE

    wait_until("it", all_inactive)
    released = [line for a, b in pairwise(seen) for line in GRIPPING_LINES if a[line] and not b[line]]
    assert released == list(reversed(GRIPPING_LINES))


@pytest.mark.thinned
def test_the_death_of_the_program_releases_what_is_declared_and_no_more(tmp_path: Path) -> None:
    """The bottom vacuum holds when its program dies, the others are unwound; a Drop releases it, too."""
    mixed = declared(bottom_vacuum={"gripping": {"process_death": "hold"}})
    with World(mixed, "nominal", tmp_path) as world:
        world.choose("never-confirms:top_vacuum")
        process = holder(world, "grip")
        wait_until("the last step", lambda: levels(world) == ALL_ACTIVE)
        kill(process)
        left = {**NONE_ACTIVE, "SODIMM_208": True}
        wait_until("the will", lambda: levels(world) == left)
        with EndEffector.open(world.description) as tool:
            tool.wait_ready(PATIENCE_S)
            assert tool.status.ee == EndEffectorState.GRIP_ERROR
            assert levels(world) == left
            wait_until("a Drop", lambda: tool.drop().succeeded)
            assert levels(world) == NONE_ACTIVE


def test_no_status_is_told_after_the_one_that_follows_it(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An alarm about a listener is told while the program goes on, in another thread."""
    with EndEffector.open(world.description) as tool:
        tool.wait_ready(30.0)
        told: list[int] = []
        completed, reads, goes_on = tool._with_notices, threading.Event(), threading.Event()

        def slowly(status: Status) -> Status:
            if threading.current_thread().name == "late":
                reads.set()
                goes_on.wait(0.5)
            return completed(status)

        monkeypatch.setattr(tool, "_with_notices", slowly)
        tool.subscribe(lambda status: told.append(status.ee))
        late = threading.Thread(name="late", target=tool._audience_changed)
        late.start()
        assert reads.wait(PATIENCE_S)
        tool._moved(replace(tool.status, ee=EndEffectorState.GRIPPED))
        goes_on.set()
        late.join()
        wait_until("both", lambda: len(told) >= 2)
        assert told[:2] == [EndEffectorState.STAND_BY, EndEffectorState.GRIPPED]
