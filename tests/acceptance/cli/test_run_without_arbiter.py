"""``eehal run`` while the line arbiter is dead: no command writes later, in either order of restart."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import time
from collections.abc import Callable
from typing import Any, Self

import pytest

from end_effector_hal.arbiter import ArbiterClient
from end_effector_lab.demo._world import World
from end_effector_lab.processes import EEHAL
from tests.support.patience import PATIENCE_S, wait_until

pytestmark = [pytest.mark.wall, pytest.mark.timeout(120)]
LONGER_THAN_A_RELEASE_S = 8.0


class Run:
    """A program that gets its commands over stdin and says what it does in JSON lines."""

    def __init__(self, world: World) -> None:
        self.process = subprocess.Popen(
            [*EEHAL, "run", str(world.description_path), "--json"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.until(lambda each: each.get("end_effector") in ("STAND_BY", "GRIPPED"))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.process.kill()
        self.process.communicate()

    def until(self, wanted: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            if wanted(said := json.loads(line)):
                return said
        raise AssertionError("it has ended")

    def give(self, word: str) -> dict[str, Any]:
        assert self.process.stdin is not None
        self.process.stdin.write(f"{word}\n")
        self.process.stdin.flush()
        return self.until(lambda each: each["event"] in ("result", "status"))

    def gives(self, word: str, outcome: str) -> None:
        said = self.give(word)
        assert (said["outcome"], said["succeeded"]) == (outcome, outcome == "SUCCEEDED"), said


def lines(world: World) -> list[bool]:
    with ArbiterClient(world.socket, "test") as observer:
        levels = observer.levels()
    return [levels[actuator.line] for _, actuator in world.description.ordered]


def kill_arbiter(world: World) -> None:
    with ArbiterClient(world.socket, "test") as observer:
        pid = int(observer.status()["pid"])
    os.kill(pid, signal.SIGKILL)
    wait_until("it is dead", lambda: world.arbiter.code is not None, PATIENCE_S)


def start_arbiter(world: World) -> None:
    again = world.children.start(
        "line arbiter again", [*EEHAL, "arbiter", str(world.description_path)], log=world.folder / "again.log"
    )
    again.wait_until(lambda: "ready:" in again.text(), timeout_s=PATIENCE_S, what="it was ready")


@pytest.mark.parametrize("away_s", [2.0, pytest.param(LONGER_THAN_A_RELEASE_S, marks=pytest.mark.thinned)])
def test_a_drop_without_the_line_arbiter_is_unreachable_and_the_part_stays_held(
    world: World, away_s: float
) -> None:
    with Run(world) as run:
        run.gives("lock", "SUCCEEDED")
        run.gives("grip", "SUCCEEDED")
        kill_arbiter(world)
        for word in ("drop", "cancel", "resume", "lock", "unlock", "arm", "reset", "stop"):
            run.gives(word, "UNREACHABLE")
        status = run.give("status")
        assert (status["state_name"], status["held"], status["arbiter_lost"]) == ("GRIPPED", True, True)
        assert [each["output"] for each in status["actuators"].values()] == [True, True, True]
        assert [alarm["id"] for alarm in status["alarms"] if "are not known now" in alarm["text"]] == [
            "arbiter.lost"
        ]
        time.sleep(away_s)
        start_arbiter(world)
        time.sleep(1.5)
        assert lines(world) == [True, True, True]
        wait_until("it is known again", lambda: not run.give("status")["arbiter_lost"])
        assert run.give("status")["state_name"] == "GRIPPED"
        run.gives("drop", "SUCCEEDED")
        assert lines(world) == [False, False, False]


def test_a_program_that_is_started_again_first_holds_the_part_too(world: World) -> None:
    with Run(world) as run:
        run.gives("lock", "SUCCEEDED")
        run.gives("grip", "SUCCEEDED")
        kill_arbiter(world)
        run.gives("drop", "UNREACHABLE")
    start_arbiter(world)
    with Run(world) as run:
        assert lines(world) == [True, True, True]
        wait_until("GRIPPED", lambda: run.give("status")["state_name"] == "GRIPPED")
        run.gives("drop", "SUCCEEDED")
        assert lines(world) == [False, False, False]
