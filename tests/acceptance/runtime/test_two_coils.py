"""An output of two coils with real processes: what is held without power is known after the arbiter was killed."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

from end_effector_hal.arbiter import ArbiterClient
from end_effector_hal.description import Description, load
from end_effector_hal.runtime import EndEffector
from end_effector_hal.verification.lemmas import COILS_FILE, coil_constants
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_hal.wires import now_us
from end_effector_hal.wires.lines import ChipLog, read_chip
from end_effector_lab.demo._world import World
from end_effector_lab.processes import EEHAL
from tests.support.patience import PATIENCE_S, wait_until
from tests.support.seen import SeenStep, seen
from timed_automata import make_network, read_document
from timed_automata.explore import Explorer

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


def is_a_run_of_the_network(world: World, killed: tuple[int, int], started: tuple[int, int]) -> bool:
    """Whether the network of two coils has what was written, with a death and a start between these times, µs.

    Commands come when they come; the arbiter is half a second late at most. What is less than 20 ms apart is one write.
    """
    coils = {"GPIO5": 1, "GPIO6": 0}
    edges = [edge for edge in ChipLog().feed(world.chip.read_bytes()) if edge.line in coils]
    begin = edges[0].at - 2_000_000
    active, moments = {1: False, 0: False}, list[tuple[int, int, str]]()
    for edge in edges:
        before = _seen(active)
        active[coils[edge.line]] = edge.active
        assert not all(active.values())
        at = (edge.at - begin) // 1000
        if moments and at - moments[-1][1] < 20:
            moments[-1] = (moments[-1][0], at + 1, _seen(active))
        elif before != _seen(active):
            moments.append((at, at + 1, _seen(active)))
    never, steps = "falls? starts?", list[SeenStep]()
    steps.append((1000, {"synchronisation": "starts?", "never": "falls?"}))
    deaths = [(*killed, "falls?"), (*started, "starts?")]
    events = [(first, last, seen_after, "") for first, last, seen_after in moments]
    events += [((a - begin) // 1000, (b - begin) // 1000 + 1, "", channel) for a, b, channel in deaths]
    now = _seen({1: False, 0: False})
    for first, last, after, channel in sorted(events):
        steps.append((first, {"guard": now, "never": never}))
        if channel:
            steps.append((last, {"synchronisation": channel, "never": never.replace(channel, "")}))
        else:
            steps.append((last, {"guard": after, "never": never}))
            now = after
    steps.append((steps[-1][0] + 1000, {"guard": now, "never": never}))
    text = COILS_FILE.read_text(encoding="utf-8").replace("\t<system>", f"{seen(steps)}\n\t<system>")
    constants = coil_constants(world.description)["pusher"] | {"D": 500}
    network = make_network(
        read_document(text.replace("Device, Watch;", "Seen;").encode(), "run.xml"), constants
    )
    return Explorer(network).check("E<> Seen.End").holds


def _seen(active: dict[int, bool]) -> str:
    return " && ".join(f"{'' if on else '!'}coil[{coil}]" for coil, on in active.items())


@pytest.mark.parametrize(
    ("pulse", "gripped", "dropped"),
    [
        pytest.param("", (True, False), (False, True), id="held", marks=pytest.mark.thinned),
        pytest.param(", pulse_s: 0.1", (False, False), (False, False), id="bistable"),
    ],
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
                before_death = now_us()
                os.kill(observer.status()["pid"], signal.SIGKILL)
        # the program ended while nobody owned the lines: what is held stays held
        after_death = now_us()
        again = world.children.start(
            "line arbiter again", [*EEHAL, "arbiter", str(world.description_path)], log=tmp_path / "again.log"
        )
        again.wait_until(lambda: "ready:" in again.text(), timeout_s=PATIENCE_S, what="it was ready")
        assert "GPIO5=1" in again.text()
        restarted = now_us()
        with EndEffector.open(world.description) as tool:
            tool.wait_ready(30.0)
            assert tool.status.ee == EndEffectorState.GRIPPED
            assert tool.drop().succeeded
            wait_until("the end of the pulse", lambda: levels(world) == dropped)
        assert is_a_run_of_the_network(world, (before_death, after_death), (after_death, restarted))
