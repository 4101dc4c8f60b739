"""Without a master, and below another name."""

from __future__ import annotations

from typing import Any

import pytest

from end_effector_hal.nodes.interface import COMMAND_ACTIONS

pytestmark = pytest.mark.ros
PARTS = {"goal", "cancel", "status", "feedback", "result"}
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


def test_a_remap_of_an_action_moves_all_its_topics(system: Any) -> None:
    import rosgraph

    graph = rosgraph.Master("/tests")
    child = system.start(
        "remapped", "rosrun", "end_effector_hal", "hal_main", "__ns:=other", "TriggerGrip:=Grasp",
        f"_description:={system.world.description_path}", "_connect:=true",
    )  # fmt: skip

    def of(name: str) -> set[str]:
        """Parts that HALMain has there; the graph is read while other nodes come and go."""
        publishers, subscribers, _ = graph.getSystemState()
        ours = (topic for topic, nodes in [*publishers, *subscribers] if "/other/HALMain" in nodes)
        return {topic.rpartition("/")[2] for topic in ours if topic.startswith(f"/other/{name}/")}

    # the last action is up: all have been put on the graph
    system.until("the actions", lambda: of("Grasp") == of(COMMAND_ACTIONS[-1].name) == PARTS)
    assert of("TriggerGrip") == set()
    child.end()
