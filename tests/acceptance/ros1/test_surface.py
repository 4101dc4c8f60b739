"""Names and types of everything on the ROS graph equal the table, and nothing else is there."""

from __future__ import annotations

from typing import Any

import pytest

from end_effector_hal.description import load, profile_path
from end_effector_hal.nodes.interface import ACTIONS, HAL_NODES, SUPERVISOR, services, topics

pytestmark = pytest.mark.ros
PARTS = {
    "goal": "ActionGoal",
    "cancel": None,
    "status": None,
    "feedback": "ActionFeedback",
    "result": "ActionResult",
}
ACTIONLIB = {"cancel": "actionlib_msgs/GoalID", "status": "actionlib_msgs/GoalStatusArray"}
DESCRIPTION = load(profile_path())
OFFERED = [action for action in ACTIONS if 1 in action.generations]


def absolute(name: str) -> str:
    return name if name.startswith("/") else f"/{name}"


@pytest.fixture
def graph(system: Any) -> Any:
    import rosgraph

    return rosgraph.Master("/tests")


def test_every_node_of_the_paper_runs_under_its_name(system: Any) -> None:
    nodes = system.cli("rosnode", "list").stdout.split()
    assert {f"/{name}" for name in HAL_NODES} | {"/DataLogger"} <= set(nodes)


@pytest.mark.parametrize("topic", topics(DESCRIPTION), ids=lambda topic: topic.name)
def test_topics(graph: Any, topic: Any) -> None:
    assert dict(graph.getTopicTypes())[absolute(topic.name)] == topic.type
    publishers = dict(graph.getSystemState()[0])
    expected = {f"/{name}" for name in topic.publishers if name != SUPERVISOR}
    assert expected <= set(publishers.get(absolute(topic.name), []))


@pytest.mark.parametrize("service", services(DESCRIPTION), ids=lambda service: service.name)
def test_services(system: Any, graph: Any, service: Any) -> None:
    import rosservice

    assert dict(graph.getSystemState()[2])[absolute(service.name)] == [f"/{service.server}"]
    assert rosservice.get_service_type(absolute(service.name)) == service.type


@pytest.mark.parametrize("action", OFFERED, ids=lambda action: action.name)
def test_actions(graph: Any, action: Any) -> None:
    types, (publishers, subscribers, _) = dict(graph.getTopicTypes()), graph.getSystemState()
    for part, suffix in PARTS.items():
        name = f"/{action.name}/{part}"
        assert types[name] == (f"{action.type}{suffix}" if suffix else ACTIONLIB[part])
        side = subscribers if part in ("goal", "cancel") else publishers
        assert f"/{action.server}" in dict(side)[name]


def test_a_remap_of_an_action_moves_all_its_topics(system: Any, graph: Any) -> None:
    child = system.start(
        "remapped", "rosrun", "end_effector_hal", "hal_main", "__ns:=other", "TriggerGrip:=Grasp",
        f"_description:={system.world.description_path}",
    )  # fmt: skip

    def of(name: str) -> set[str]:
        """Parts that HALMain has there; the graph is read while other nodes come and go."""
        publishers, subscribers, _ = graph.getSystemState()
        ours = (topic for topic, nodes in [*publishers, *subscribers] if "/other/HALMain" in nodes)
        return {topic.rpartition("/")[2] for topic in ours if topic.startswith(f"/other/{name}/")}

    # the last action is up: all have been put on the graph
    system.until("the actions", lambda: of("Grasp") == of(OFFERED[-1].name) == set(PARTS))
    assert of("TriggerGrip") == set()
    child.end()


def test_nothing_else_is_published_or_served(graph: Any) -> None:
    publishers, _, served = graph.getSystemState()
    ours = {f"/{name}" for name in HAL_NODES}
    found = {name for name, nodes in publishers if ours & set(nodes)} - {"/rosout"}
    declared = {absolute(topic.name) for topic in topics(DESCRIPTION)}
    declared |= {f"/{action.name}/{part}" for action in OFFERED for part in PARTS}
    assert found <= declared
    names = {name for name, nodes in served if ours & set(nodes)}
    loggers = {f"{node}/{kind}" for node in ours for kind in ("get_loggers", "set_logger_level")}
    assert names - loggers == {absolute(service.name) for service in services(DESCRIPTION)}


def test_the_names_are_those_of_the_paper(graph: Any) -> None:
    served = {name for name, _ in graph.getSystemState()[2]}
    assert {"/SetToolChanger", "/SetBottomVacuum", "/SetCylinder", "/SetTopVacuum"} <= served
    names = {name for name, _ in graph.getTopicTypes()}
    assert {"/EndEffectorState", "/PressureVacuumBottom", "/PressureCylinder", "/PressureVacuumTop"} <= names
    assert {"/PositionCylinder", "/PositionToolChanger", "/sensor_frame", "/diagnostics"} <= names
