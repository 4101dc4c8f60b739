"""An output of two coils with real processes: what is held without power is known after the arbiter was killed."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

from end_effector_hal.arbiter import ArbiterClient
from end_effector_hal.description import Description, load
from end_effector_hal.runtime import EndEffector
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_hal.wires.lines import ChipLog, read_chip
from end_effector_lab.demo._world import World
from end_effector_lab.processes import EEHAL
from tests.support.patience import PATIENCE_S, wait_until

pytestmark = [pytest.mark.wall, pytest.mark.timeout(90)]

TOOL = """
schema: 2
name: two_coils
lines: {backend: gpiod}
link: {port: /dev/ttyUSB0, codec: ees1-ascii}
sequence: [pusher]
actuators:
  pusher:
    kind: cylinder
    line: GPIO5
    opposite: {line: GPIO6%s}
    channel: cylinder
"""


def two_coils(folder: Path, pulse: str) -> Description:
    path = folder / "two_coils.yaml"
    path.write_text(TOOL % pulse, encoding="utf-8")
    return load(path)


def levels(world: World) -> tuple[bool, bool]:
    """Of the two coils."""
    lines = read_chip(world.chip).lines
    return bool(lines["GPIO5"].level), bool(lines["GPIO6"].level)


def never_both(world: World) -> None:
    active = {"GPIO5": False, "GPIO6": False}
    for edge in ChipLog().feed(world.chip.read_bytes()):
        active[edge.line] = edge.active
        assert not all(active.values())


@pytest.mark.parametrize(
    ("pulse", "gripped", "dropped"),
    [("", (True, False), (False, True)), (", pulse_s: 0.1", (False, False), (False, False))],
    ids=["held", "bistable"],
)
def test_a_killed_arbiter_knows_what_its_coils_have_moved(
    tmp_path: Path, pulse: str, gripped: tuple[bool, bool], dropped: tuple[bool, bool]
) -> None:
    with World(two_coils(tmp_path, pulse), "nominal", tmp_path) as world:
        with EndEffector.open(world.description) as tool:
            tool.wait_ready(30.0)
            assert tool.status.ee == EndEffectorState.STAND_BY
            assert tool.grip().succeeded
            wait_until("the end of the pulse", lambda: levels(world) == gripped)
            with ArbiterClient(world.socket, "test") as observer:
                os.kill(observer.status()["pid"], signal.SIGKILL)
        # the program ended while nobody owned the lines: what is held stays held
        again = world.children.start(
            "line arbiter again", [*EEHAL, "arbiter", str(world.description_path)], log=tmp_path / "again.log"
        )
        again.wait_until(lambda: "ready:" in again.text(), timeout_s=PATIENCE_S, what="it was ready")
        assert "GPIO5=1" in again.text()
        with EndEffector.open(world.description) as tool:
            tool.wait_ready(30.0)
            assert tool.status.ee == EndEffectorState.GRIPPED
            assert tool.drop().succeeded
            wait_until("the end of the pulse", lambda: levels(world) == dropped)
        never_both(world)
