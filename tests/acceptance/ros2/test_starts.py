"""Arguments of ROS 2 that are wrong; the Supervisor in a namespace."""

from __future__ import annotations

from typing import Any

from end_effector_hal.description import load, profile_path
from end_effector_lab.demo._ros import ONE
from end_effector_lab.demo._world import World
from tests.acceptance.ros2.conftest import System


def test_an_argument_that_is_none_of_ros_is_told(running: Any) -> None:
    ended = running.run("hal", "--ros-args", "-p", "description")
    assert ended.returncode == 2
    assert "Traceback" not in ended.stderr


def test_two_nodes_of_one_name_are_refused(running: Any) -> None:
    ended = running.run("hal", "--ros-args", "-p", "profile:=verdin_gripper", "-r", "__node:=same")
    assert ended.returncode == 2
    assert "would be called same" in ended.stderr


def test_the_supervisor_commands_a_tool_in_its_namespace(tmp_path: Any) -> None:
    with World(load(profile_path()), "nominal", tmp_path) as world:
        left = System(world, tmp_path, ONE)
        nodes = [left.start(program, "-r", "__ns:=/left") for program in ONE]
        left.until(
            "a locked tool", lambda: any("tool changer: UNKNOWN -> LOCKED" in node.text() for node in nodes)
        )
        given = left.start("supervisor", "-p", "script:=lock; grip; drop", "-r", "__ns:=/left")
        left.until("its end", lambda: given.code is not None)
        assert given.code == 0, given.text()
        assert given.text().count("SUCCEEDED") == 3
