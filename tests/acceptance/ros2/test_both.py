"""One tool that `eehal serve` runs, with nodes of ROS 1 and of ROS 2 at the same time."""

from __future__ import annotations

import os
import signal
import subprocess
from pathlib import Path

import pytest

from end_effector_hal.description import load, profile_path
from end_effector_hal.errors import RosError
from end_effector_lab.demo._ros import ONE, RUN, Master
from end_effector_lab.demo._world import World
from end_effector_lab.processes import EEHAL, Child
from tests.acceptance.ros2.conftest import System, without_wheels
from tests.support.places import ROOT

SOURCED = ROOT / "build/catkin/devel/setup.bash"
START_S = 90.0


def env_of_ros1(folder: Path) -> tuple[Master, dict[str, str]]:
    """A master, and the environment of its nodes: that of `make setup`, with the workspace sourced."""
    script = f"source {SOURCED} && PATH={ROOT}/.venv/bin:$PATH exec env -0"
    done = subprocess.run(["bash", "-c", script], env=without_wheels(), capture_output=True, check=True)
    sourced = dict(each.split("=", 1) for each in done.stdout.decode().split("\0") if each)
    master = Master(folder / "ros1")
    master.env = {**sourced, **master.env, "PATH": sourced["PATH"]}
    return master, master.env


@pytest.mark.skipif(not SOURCED.exists(), reason="the workspace of ROS 1 is not built: make setup")
def test_nodes_of_both_generations_command_one_tool(tmp_path: Path) -> None:
    with World(load(profile_path()), "nominal", tmp_path) as world:
        start = world.children.start
        serve = start(
            "serve", [*EEHAL, "serve", str(world.description_path)], log=tmp_path / "serve.log",
            end_by=signal.SIGINT, patience_s=20.0,
        )  # fmt: skip
        newer = System(world, tmp_path, ONE)
        nodes = [newer.start(program, "-p", "connect:=true") for program in ONE]

        master, env = env_of_ros1(tmp_path)
        master.start(world.children, tmp_path / "roscore.log", patience_s=START_S)
        tool = f"_description:={world.description_path.absolute()}"

        def older(program: str, *more: str) -> Child:
            return start(
                program, [*RUN, program, tool, *more], log=tmp_path / f"ros1-{program}.log", failed=RosError,
                env=env, end_by=signal.SIGINT, patience_s=20.0,
            )  # fmt: skip

        nodes.append(older("hal_main", "_connect:=true"))
        older("pressure")

        given = older("supervisor", "_script:=lock; grip; quit")
        newer.until("a grip by ROS 1", lambda: given.code is not None)
        assert given.code == 0, given.text()
        for node in nodes:
            newer.until("it is seen", lambda node=node: "GRIPPING -> GRIPPED" in node.text())

        given = newer.start("supervisor", "-p", "script:=drop; quit")
        newer.until("a drop by ROS 2", lambda: given.code is not None)
        assert given.code == 0, given.text()
        for node in nodes:
            newer.until("it is seen", lambda node=node: "RELEASING -> STAND_BY" in node.text())
            os.kill(node.pid, signal.SIGKILL)
        newer.until("the death of both", lambda: all(node.code is not None for node in nodes))
        assert serve.code is None
        assert "STAND_BY" in subprocess.run(
            [*EEHAL, "status", str(world.description_path)], capture_output=True, text=True, check=True
        ).stdout  # fmt: skip
