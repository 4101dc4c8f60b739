"""The program of examples/programs beside `eehal serve`: it grips and reports, and its death leaves the part held."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from end_effector_hal.description import load, profile_path
from end_effector_hal.runtime import EndEffector, RemoteTool
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_lab.demo import World
from end_effector_lab.processes import EEHAL
from tests.support.patience import PATIENCE_S, wait_until
from tests.support.places import ROOT

pytestmark = [pytest.mark.wall, pytest.mark.timeout(180)]
PROGRAM = ROOT / "examples/programs/ten_grips.py"


@pytest.fixture
def world(tmp_path: Path) -> Iterator[World]:
    with World(load(profile_path()), "nominal", tmp_path) as world:
        yield world


@pytest.fixture
def tool(world: World) -> Iterator[RemoteTool]:
    world.children.start("hal", [*EEHAL, "serve", str(world.description_path)], log=world.folder / "hal.log")
    with EndEffector.connect(world.description_path, timeout_s=PATIENCE_S) as tool:
        tool.wait_ready(PATIENCE_S)
        yield tool


def start(world: World, grips: int) -> subprocess.Popen[str]:
    command = [sys.executable, PROGRAM, world.description_path, str(grips)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def test_it_grips_and_reports(world: World, tool: RemoteTool) -> None:
    program = start(world, 2)
    out, err = program.communicate(timeout=PATIENCE_S)
    assert (program.returncode, err) == (0, ""), out
    assert "Grip 2: SUCCEEDED" in out
    assert "2 of 2 grips confirmed, 2 at the first attempt." in out
    assert not tool.status.held


def test_its_death_leaves_the_part_held_and_the_next_one_does_nothing(world: World, tool: RemoteTool) -> None:
    program = start(world, 10)
    wait_until("the grip", lambda: tool.status.ee is EndEffectorState.GRIPPING)
    program.kill()
    program.communicate()
    wait_until("its end", lambda: tool.status.ee is EndEffectorState.GRIPPED)
    again = start(world, 10)
    out, _ = again.communicate(timeout=PATIENCE_S)
    assert (again.returncode, tool.status.held) == (1, True)
    assert out == "A part is held already: nothing was done. Drop it first.\n"


def test_without_the_tool_it_says_what_to_start(world: World) -> None:
    program = start(world, 1)
    _, err = program.communicate(timeout=PATIENCE_S)
    assert program.returncode == 1
    assert "eehal serve" in err
    assert "Traceback" not in err
