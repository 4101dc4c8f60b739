"""A blow-off with real processes: whoever dies in the middle of it, it ends, ends first, and does not begin again."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from end_effector_hal.arbiter import ArbiterClient
from end_effector_hal.description import load
from end_effector_hal.errors import LineRefusedError
from end_effector_hal.runtime import EndEffector
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_hal.wires.lines import ChipLog, Edge
from end_effector_lab.demo._world import World
from end_effector_lab.processes import EEHAL, Child
from tests.support.nightly import first_of
from tests.support.patience import PATIENCE_S, wait_until

pytestmark = [pytest.mark.wall, pytest.mark.timeout(120)]

TOOL = """
schema: 2
name: blown
lines: {backend: gpiod}
link: {port: /dev/ttyUSB0, codec: ees1-ascii}
sequence: [left, right]
actuators:
  left: {kind: vacuum, line: LEFT, channel: bottom}
  right: {kind: vacuum, line: RIGHT, channel: top, blow_off: {line: AIR, gap_s: 0.4, duration_s: 4}}
"""
PHASES = {
    "in the gap": [("RIGHT", False)],
    "while it blows": [("RIGHT", False), ("AIR", True)],
    "at rest": [("RIGHT", False), ("AIR", True), ("AIR", False)],
}


class Seen:
    """What has been written to the lines."""

    def __init__(self, world: World) -> None:
        self._path = world.chip

    @property
    def edges(self) -> list[tuple[str, bool]]:
        """Changes of all lines."""
        found: list[tuple[str, bool]] = []
        levels = dict.fromkeys(("LEFT", "RIGHT", "AIR"), False)
        for edge in ChipLog().feed(self._path.read_bytes()):
            if levels.get(edge.line, edge.active) != edge.active:
                levels[edge.line] = edge.active
                found.append((edge.line, edge.active))
                assert not (levels["AIR"] and levels["RIGHT"]), "suction and blow-off together"
        return found

    @property
    def released(self) -> list[tuple[str, bool]]:
        """Those since the release began, of a grip that may have taken several attempts."""
        edges = self.edges
        gripped = max((at for at, edge in enumerate(edges) if edge == ("RIGHT", True)), default=len(edges))
        return edges[gripped + 1 :]

    def last(self, line: str, *, active: bool) -> Edge:
        edges = (each for each in ChipLog().feed(self._path.read_bytes()) if each.line == line)
        return [each for each in edges if each.active == active][-1]


@pytest.fixture
def world(tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[World]:
    path = tmp_path / "blown.yaml"
    path.write_text(
        TOOL.replace("duration_s: 4", getattr(request, "param", "duration_s: 4")), encoding="utf-8"
    )
    with World(load(path), "nominal", tmp_path) as world:
        yield world


def dropping(world: World) -> Child:
    """The program, with several Drops: on a busy machine an output moves so late that the arbiter refuses to blow."""
    script = "; ".join(["grip; drop; wait 1"] * 4)
    words = [*EEHAL, "run", str(world.description_path), "--script", script]
    return world.children.start("program", words, log=world.folder / "program.log")


def arbiter(world: World) -> int:
    with ArbiterClient(world.socket, "test") as observer:
        return int(observer.status()["pid"])


def start_arbiter(world: World) -> None:
    words = [*EEHAL, "arbiter", str(world.description_path)]
    again = world.children.start("line arbiter again", words, log=world.folder / "again.log")
    again.wait_until(lambda: "ready:" in again.text(), timeout_s=PATIENCE_S, what="it was ready")


@pytest.mark.parametrize("world", ["duration_s: 1"], indirect=True)
@pytest.mark.parametrize("phase", first_of(sorted(PHASES, reverse=True), 1, 1))
def test_a_killed_program_blows_no_longer(world: World, phase: str) -> None:
    """Its last will ends the blow-off, then carries the release out; nobody blows by a last will."""
    seen, program = Seen(world), dropping(world)
    wait_until(f"a release {phase}", lambda: seen.released == PHASES[phase], PATIENCE_S)
    os.kill(program.pid, signal.SIGKILL)
    wait_until("the end of the release", lambda: ("LEFT", False) in seen.released)
    assert [edge for edge in seen.released if edge not in PHASES[phase]] == (
        [("AIR", False), ("LEFT", False)] if phase == "while it blows" else [("LEFT", False)]
    )
    blown = seen.edges.count(("AIR", True))
    with EndEffector.open(world.description) as tool:
        tool.wait_ready(30.0)
        assert tool.status.ee == EndEffectorState.STAND_BY
        wait_until("a grip: by then all is gone", lambda: tool.grip().succeeded)
        assert tool.drop().succeeded
    assert seen.edges.count(("AIR", True)) <= blown + 1


@pytest.mark.parametrize(
    "hit", first_of([signal.SIGSTOP, signal.SIGTERM], thinned=0), ids=["hangs", "is told to end"]
)
def test_a_program_that_hangs_or_ends_blows_no_longer(world: World, hit: signal.Signals) -> None:
    seen, program = Seen(world), dropping(world)
    wait_until("blowing", lambda: seen.released == PHASES["while it blows"], PATIENCE_S)
    os.kill(program.pid, hit)
    wait_until("the end of the release", lambda: ("LEFT", False) in seen.released)
    assert seen.released == [*PHASES["while it blows"], ("AIR", False), ("LEFT", False)]
    blown_us = seen.last("AIR", active=False).at - seen.last("AIR", active=True).at
    assert blown_us < 3_500_000  # of 4 s: a lease is 1 s
    os.kill(program.pid, signal.SIGCONT)


@pytest.mark.parametrize("also_program", first_of([True, False]), ids=["with its program", "alone"])
def test_a_killed_line_arbiter_ends_it_when_it_is_back(world: World, also_program: bool) -> None:
    seen, program = Seen(world), dropping(world)
    wait_until("blowing", lambda: seen.released == PHASES["while it blows"], PATIENCE_S)
    os.kill(arbiter(world), signal.SIGKILL)
    if also_program:
        os.kill(program.pid, signal.SIGKILL)
    assert seen.released == PHASES["while it blows"]
    start_arbiter(world)
    wait_until("the end of the release", lambda: ("LEFT", False) in seen.released, PATIENCE_S)
    assert seen.released == [*PHASES["while it blows"], ("AIR", False), ("LEFT", False)]


def test_the_line_arbiter_ends_it_where_nobody_else_does(world: World) -> None:
    """A program that lives, and writes no end."""
    lines = ("LEFT", "RIGHT", "AIR")
    with ArbiterClient(world.socket, "grip", lines) as hand:
        wait_until("a blow-off that is accepted", lambda: _blows(hand))
        wait_until("its end", lambda: not hand.levels()["AIR"], PATIENCE_S)
        assert "IL-08 AIR" in hand.status()["faults"]
    seen = Seen(world)
    blown_us = seen.last("AIR", active=False).at - seen.last("AIR", active=True).at
    assert 4_000_000 < blown_us < 4_500_000  # duration_s, and twice the reaction bound of 50 ms


def _blows(hand: ArbiterClient) -> bool:
    """Not within the gap after the arbiter has begun: until then suction may have been active."""
    with suppress(LineRefusedError):
        hand.set({"AIR": True})
    return hand.levels()["AIR"]
