"""In PID namespaces of their own, as in containers, every program is pid 0 to the line arbiter."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import pytest

from end_effector_hal.arbiter import ArbiterClient
from end_effector_hal.description import load, profile_path
from end_effector_hal.wires.lines import read_chip
from end_effector_lab.demo._world import World
from end_effector_lab.processes import EEHAL
from tests.support.patience import PATIENCE_S, wait_until

pytestmark = [pytest.mark.wall, pytest.mark.timeout(120)]
ALONE = ("unshare", "--pid", "--fork", "--mount-proc", "--kill-child")
GRIP = """
import sys, threading
from end_effector_hal.runtime import EndEffector
from end_effector_hal.vocabulary import EndEffectorState as State
from end_effector_lab.processes import EEHAL
tool = EndEffector.open(sys.argv[1])
tool.wait_ready(30.0)
if "grip" in sys.argv:
    tool.grip()
print(State(tool.status.ee).name, flush=True)
threading.Event().wait()
"""


@contextmanager
def alone(command: Sequence[object]) -> Iterator[subprocess.Popen[str]]:
    """A program in a PID namespace of its own; what is left of it is killed at the end."""
    with subprocess.Popen([*ALONE, *map(str, command)], stdout=subprocess.PIPE, text=True) as process:
        try:
            yield process
        finally:
            process.kill()


def kill(process: subprocess.Popen[str]) -> None:
    """The program, which is the first process of its namespace; wait for its end."""
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text(encoding="ascii")
    os.kill(int(children), signal.SIGKILL)
    process.wait(PATIENCE_S)


def test_what_two_killed_programs_have_left_is_unwound_though_both_are_pid_0(tmp_path: Path) -> None:
    with World(load(profile_path()), "nominal", tmp_path) as world:
        arbiter = [*EEHAL, "arbiter", world.description_path]
        program = [sys.executable, "-c", GRIP, world.description_path]
        lines = [actuator.line for _, actuator in world.description.ordered]

        def active() -> list[bool]:
            return [bool(read_chip(world.chip).lines[line].level) for line in lines]

        with ArbiterClient(world.socket, "look") as look:
            outside = look.status()["pid"]
        os.kill(outside, signal.SIGTERM)
        wait_until("the end of the arbiter outside", lambda: not world.socket.exists())
        world.choose("never-confirms:top_vacuum")
        with alone(arbiter) as first, alone([*program, "grip"]) as gripping:
            assert first.stdout is not None
            assert "ready" in first.stdout.readline()
            wait_until("the last step of GRIPPING", lambda: all(active()))
            with ArbiterClient(world.socket, "look") as look:
                assert {client["pid"] for client in look.status()["clients"]} == {0}
            kill(first)
            kill(gripping)
        assert all(active())
        with alone(program) as again, alone(arbiter):
            assert again.stdout is not None
            assert again.stdout.readline() == "STAND_BY\n", (
                "the will was executed before the next one adopted"
            )
            assert not any(active())
