"""Without a master, and below another name."""

from __future__ import annotations

import signal
from pathlib import Path
from typing import Any

import pytest

from end_effector_hal.description import load, profile_path
from end_effector_lab.demo._world import World

pytestmark = pytest.mark.ros
NODES = ("hal_main", "grip", "tool_change", "pressure", "position", "supervisor", "data_logger")


def test_without_a_master_every_node_says_so_and_ends_with_3(system: Any) -> None:
    uri = f"http://127.0.0.1:{system.free_port()}"
    children = [
        system.start(f"alone_{name}", "rosrun", "end_effector_hal", name, env={"ROS_MASTER_URI": uri})
        for name in NODES
    ]
    for name, child in zip(NODES, children, strict=True):
        assert child.wait_for_end(timeout_s=30.0) == 3, name
        said = child.text().strip()
        assert said.startswith(f"{name}: The ROS master at {uri} cannot be reached")
        assert said.endswith("Start roscore, or use roslaunch.")
        assert "\n" not in said


def test_everything_moves_into_a_namespace(system: Any, tmp_path: Path) -> None:
    import actionlib
    import rosgraph
    import rospy
    from end_effector_msgs.msg import EndEffectorAction, EndEffectorGoal

    with World(load(profile_path()), "nominal", tmp_path) as world:
        launch = system.launch(world, name="cell", env={"ROS_NAMESPACE": "/cell_1"})
        try:
            client = actionlib.SimpleActionClient("/cell_1/TriggerGrip", EndEffectorAction)
            assert client.wait_for_server(rospy.Duration(60))

            def gripped() -> bool:
                return bool(client.send_goal_and_wait(EndEffectorGoal(), rospy.Duration(60)) == 3)

            system.until("a grip", gripped)
            assert system.state.state == 6, "the other tool has not moved"
            names = {name for name, _ in rosgraph.Master("/tests").getTopicTypes()}
            assert {"/cell_1/EndEffectorState", "/cell_1/PressureVacuumBottom", "/cell_1/grip/state"} <= names
            services = {name for name, _ in rosgraph.Master("/tests").getSystemState()[2]}
            assert {"/cell_1/SetBottomVacuum", "/cell_1/SetToolChanger"} <= services
        finally:
            launch.end(signal_number=signal.SIGINT, patience_s=20.0)
