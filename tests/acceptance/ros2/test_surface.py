"""Names and types of everything on the ROS 2 graph equal the table."""

from __future__ import annotations

from typing import Any

import pytest

from end_effector_hal.description import load, profile_path
from end_effector_hal.nodes.interface import ACTIONS, HAL_NODES, SUPERVISOR, services, topics

TOOL = load(profile_path())


def in_ros2(name: str, kind: str) -> str:
    return name.replace("/", f"/{kind}/")


def absolute(name: str) -> str:
    return name if name.startswith("/") else f"/{name}"


@pytest.mark.parametrize("name", HAL_NODES)
def test_every_node_of_the_paper_runs_under_its_name(system: Any, name: str) -> None:
    system.until(name, lambda: name in system.node.get_node_names())


@pytest.mark.parametrize("topic", topics(TOOL), ids=lambda topic: topic.name)
def test_topics(system: Any, topic: Any) -> None:
    expected = {name for name in topic.publishers if name in HAL_NODES}
    if topic.publishers == (SUPERVISOR,):
        pytest.skip("there is no Supervisor")

    def found() -> bool:
        infos = system.node.get_publishers_info_by_topic(absolute(topic.name))
        return expected <= {info.node_name for info in infos}

    system.until("its publishers", found)
    for info in system.node.get_publishers_info_by_topic(absolute(topic.name)):
        assert info.topic_type == in_ros2(topic.type, "msg")
        assert (info.qos_profile.durability.name == "TRANSIENT_LOCAL") == topic.latched


@pytest.mark.parametrize("service", services(TOOL), ids=lambda service: service.name)
def test_services(system: Any, service: Any) -> None:
    def served() -> dict[str, list[str]]:
        return dict(system.node.get_service_names_and_types_by_node(service.server, "/"))

    system.until("the node is in the graph", lambda: service.server in system.node.get_node_names())
    if service.internal and not system.five:
        assert absolute(service.name) not in served(), "within a process it needs no service"
        return
    system.until(
        "the service", lambda: served().get(absolute(service.name)) == [in_ros2(service.type, "srv")]
    )


@pytest.mark.parametrize("action", ACTIONS, ids=lambda action: action.name)
def test_actions(system: Any, action: Any) -> None:
    from rclpy.action import get_action_names_and_types

    found = dict(get_action_names_and_types(system.node))
    assert found[absolute(action.name)] == [in_ros2(action.type, "action")]
