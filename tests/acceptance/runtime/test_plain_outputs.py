"""Outputs beside the grip, with real processes: switched at any time, and left as declared when their process ends."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator

import pytest

from end_effector_hal.arbiter import ArbiterClient
from end_effector_hal.errors import UsageError
from end_effector_hal.runtime import EndEffector
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_lab.demo._world import World
from end_effector_lab.processes import EEHAL, Child
from tests.support.nightly import first_of
from tests.support.patience import PATIENCE_S, wait_until

pytestmark = [pytest.mark.wall, pytest.mark.timeout(120)]

TOOL = """
schema: 2
name: lit
lines: {backend: gpiod}
link: {port: /dev/ttyUSB0, codec: ees1-ascii}
sequence: [cup]
actuators:
  cup: {kind: vacuum, line: CUP, channel: bottom}
outputs:
  lamp: {line: LAMP}
  fan: {line: FAN, on_death: keep}
"""


@pytest.fixture
def observer(world: World) -> Iterator[ArbiterClient]:
    with ArbiterClient(world.socket, "test") as client:
        yield client


def lit(world: World) -> Child:
    words = [*EEHAL, "run", str(world.description_path), "--script"]
    script = "set lamp on; set fan on; grip; wait 600"
    return world.children.start("program", [*words, script], log=world.folder / "program.log")


def test_they_are_switched_while_a_part_is_held_and_move_nothing_of_it(
    world: World, observer: ArbiterClient
) -> None:
    with EndEffector.open(world.description) as tool:
        tool.wait_ready(30.0)
        assert tool.outputs == {"lamp": False, "fan": False}
        assert tool.grip().succeeded
        said = tool.set_output("lamp", True)
        assert (said.accepted, said.reason) == (True, "Lamp is on; no sensor proves it.")
        assert tool.outputs == {"lamp": True, "fan": False}
        assert tool.status.ee == EndEffectorState.GRIPPED
        with pytest.raises(UsageError, match=r"'lam' is no output of lit\..*lamp"):
            tool.set_output("lam", True)
    wait_until("the lamp is off", lambda: not observer.levels()["LAMP"])
    assert observer.levels() == {"CUP": True, "LAMP": False, "FAN": False}


@pytest.mark.parametrize(
    "hit", first_of([signal.SIGKILL, signal.SIGSTOP, signal.SIGTERM], 1, 1), ids=lambda each: each.name
)
def test_what_their_process_leaves_is_what_is_declared(
    world: World, observer: ArbiterClient, hit: signal.Signals
) -> None:
    """And the held part stays held."""
    program = lit(world)
    wait_until("GRIPPED", lambda: "GRIP: succeeded" in program.text(), PATIENCE_S)
    assert observer.levels() == {"CUP": True, "LAMP": True, "FAN": True}
    os.kill(program.pid, hit)
    wait_until("the lamp is off", lambda: not observer.levels()["LAMP"], PATIENCE_S)
    assert observer.levels() == {"CUP": True, "LAMP": False, "FAN": True}
    os.kill(program.pid, signal.SIGCONT)


def test_a_line_arbiter_that_was_killed_finds_them_as_they_are(world: World) -> None:
    program = lit(world)
    wait_until("GRIPPED", lambda: "GRIP: succeeded" in program.text(), PATIENCE_S)
    with ArbiterClient(world.socket, "test") as observer:
        os.kill(int(observer.status()["pid"]), signal.SIGKILL)
    again = world.children.start(
        "line arbiter again", [*EEHAL, "arbiter", str(world.description_path)], log=world.folder / "again.log"
    )
    again.wait_until(lambda: "ready:" in again.text(), timeout_s=PATIENCE_S, what="it was ready")
    with ArbiterClient(world.socket, "test") as observer:
        assert observer.levels() == {"CUP": True, "LAMP": True, "FAN": True}
        os.kill(program.pid, signal.SIGKILL)
        wait_until("the lamp is off", lambda: not observer.levels()["LAMP"], PATIENCE_S)
        assert observer.levels() == {"CUP": True, "LAMP": False, "FAN": True}
