"""Two of the same on one end-effector: the second says who is there, leaves with exit code 3, and changes nothing."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from end_effector_hal.arbiter import ArbiterClient
from end_effector_hal.description import load, profile_path
from end_effector_lab.demo._world import World
from end_effector_lab.processes import EEHAL
from tests.support.patience import PATIENCE_S

pytestmark = [pytest.mark.wall, pytest.mark.timeout(90)]


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[World]:
    with World(load(profile_path()), "nominal", tmp_path_factory.mktemp("world")) as running:
        yield running


@pytest.fixture
def running(world: World) -> Iterator[subprocess.Popen[str]]:
    """The first: `eehal run` at a prompt, adopted."""
    command = [*EEHAL, "run", str(world.description_path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            assert process.stdin is not None
            while "STAND_BY" not in (line := process.stdout.readline()):
                assert line, "it ended"
            yield process
            process.stdin.close()
            assert process.wait(PATIENCE_S) == 0
        finally:
            process.kill()


def second(*arguments: object) -> str:
    """Its only sentence; it must leave by itself, with the exit code for hardware that cannot be had."""
    done = subprocess.run(
        [*EEHAL, *map(str, arguments)], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 3, done
    assert done.stderr.count("\n") == 1, done.stderr
    return done.stderr


def test_a_second_hal_is_told_who_writes_the_lines(world: World, running: subprocess.Popen[str]) -> None:
    said = second("run", world.description_path, "--script", "lock")
    assert f"belongs to hal (pid {running.pid}, " in said
    assert "run" in said
    assert running.poll() is None


def test_a_second_arbiter_at_the_same_socket_is_told_who_serves_it(world: World) -> None:
    with ArbiterClient(world.socket, "look") as look:
        first = look.status()["pid"]
        said = second("arbiter", world.description_path)
        assert f"the socket of the line arbiter is held by pid {first} (" in said
        assert look.status()["pid"] == first


def test_a_second_arbiter_of_the_same_lines_is_told_who_has_them(world: World, tmp_path: Path) -> None:
    with ArbiterClient(world.socket, "look") as look:
        first = look.status()["pid"]
        said = second("arbiter", world.description_path, "--socket", tmp_path / "other.sock")
        assert f"the virtual chip is held by pid {first} (" in said
        assert look.levels()
    assert not (tmp_path / "other.sock").exists()


def test_a_second_reader_of_the_same_port_is_told_who_reads_it(
    world: World, running: subprocess.Popen[str], tmp_path: Path
) -> None:
    # with lines and an arbiter of its own: only the sensor link is shared
    chip, socket = tmp_path / "chip", tmp_path / "other.sock"
    chip.write_bytes(world.chip.read_bytes())
    text, other = world.description_path.read_text(encoding="utf-8"), tmp_path / "tool.yaml"
    for mine, its in ((world.chip, chip), (world.socket, socket)):
        assert text.count(str(mine)) == 1
        text = text.replace(str(mine), str(its))
    other.write_text(text, encoding="utf-8")
    with subprocess.Popen([*EEHAL, "arbiter", str(other)], stdout=subprocess.PIPE, text=True) as arbiter:
        try:
            assert arbiter.stdout is not None
            assert "ready" in arbiter.stdout.readline()
            begun = time.monotonic()
            said = second("run", other, "--script", "lock")
            assert f"the port is used by pid {running.pid} (" in said or f"and pid {running.pid} (" in said
            assert time.monotonic() - begun < 30
            arbiter.terminate()
            arbiter.wait(PATIENCE_S)
        finally:
            arbiter.kill()
    assert arbiter.returncode == 0
    assert running.poll() is None
