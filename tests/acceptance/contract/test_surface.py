"""Everything on the graph: its type, its direction, its latching and its rate; and nothing else is there.

The lists stand here, not in the table of the product: a change of that table is a change of the contract.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import pytest

from tests.acceptance.contract.differences import Difference
from tests.acceptance.contract.driver import Heard, Message
from tests.acceptance.contract.hal import ACTION, NODES, Hal

pytestmark = pytest.mark.ros
FRAMES, STATES, HEALTH = "at each frame", "at 10 Hz", "once a second"


@dataclass(frozen=True)
class Topic:
    """A topic. No node of the HAL subscribes to any."""

    name: str
    type: str
    rate: str
    writers: tuple[str, ...]
    latched: bool = False


def pressure(name: str) -> Topic:
    return Topic(name, "sensor_msgs/FluidPressure", FRAMES, ("Pressure",))


def position(name: str, kind: str) -> Topic:
    return Topic(name, f"end_effector_msgs/{kind}", STATES, ("Position",), latched=True)


TOPICS = (
    Topic("EndEffectorState", "end_effector_msgs/EndEffectorState", STATES, ("HALMain",), latched=True),
    pressure("PressureVacuumBottom"),
    pressure("PressureCylinder"),
    pressure("PressureVacuumTop"),
    pressure("PressureSupply"),
    position("PositionCylinder", "CylinderPosition"),
    position("PositionToolChanger", "ToolChangerPosition"),
    position("PositionToolStand", "ToolStandPosition"),
    Topic("joint_states", "sensor_msgs/JointState", STATES, ("Position",)),
    Topic("/diagnostics", "diagnostic_msgs/DiagnosticArray", HEALTH, NODES),
)
SERVICES = {
    "SetBottomVacuum": ("std_srvs/SetBool", "Grip"),
    "SetCylinder": ("std_srvs/SetBool", "Grip"),
    "SetTopVacuum": ("std_srvs/SetBool", "Grip"),
    "SetToolChanger": ("std_srvs/SetBool", "ToolChange"),
    "ArmToolChanger": ("std_srvs/Trigger", "ToolChange"),
    "ResetFaults": ("std_srvs/Trigger", "Grip"),
    "ResumeGrip": ("std_srvs/Trigger", "Grip"),
    "StopTool": ("std_srvs/Trigger", "Grip"),
}
ACTIONS = ("LockToolChanger", "UnlockToolChanger", "TriggerGrip", "Drop")
GRIPPER_CMD = {
    "gripper_controller/gripper_cmd": "control_msgs/GripperCommand",
    "parallel_gripper_controller/gripper_cmd": "control_msgs/ParallelGripperCommand",
}

of_each_topic = pytest.mark.parametrize("topic", TOPICS, ids=lambda topic: topic.name)


def entities(hal: Hal, what: str, name: str) -> set[tuple[str, str]]:
    """Type and node of whoever publishes, subscribes to or serves that name."""
    return {
        (each["type"], each["node"])
        for each in hal.driver.graph()
        if (each["is"], each["name"]) == (what, hal.full(name))
    }


def expect(hal: Hal, what: str, name: str, wanted: set[tuple[str, str]]) -> None:
    """What the graph shows in the end: a node is discovered one entity after the other."""
    seen: list[set[tuple[str, str]]] = []

    def found() -> bool:
        seen[:] = [entities(hal, what, name)]
        return seen == [wanted]

    try:
        hal.until(f"{what} {name}", found, 10.0)
    except AssertionError:
        assert seen == [wanted]


@pytest.mark.parametrize("node", NODES)
def test_every_node_of_the_paper_runs_under_its_name(hal: Hal, node: str) -> None:
    hal.until(node, lambda: hal.driver.ask("nodes").count(f"/{node}") == 1)


@of_each_topic
def test_a_topic_has_its_type_and_its_publishers(hal: Hal, topic: Topic) -> None:
    expect(hal, "publisher", topic.name, {(topic.type, f"/{node}") for node in topic.writers})


@of_each_topic
def test_no_node_subscribes_to_a_topic(hal: Hal, topic: Topic) -> None:
    """Nothing that anybody publishes counts as a sensor or a status."""
    readers = {node for _, node in entities(hal, "subscriber", topic.name)}
    assert not [node for node in readers if node.rpartition("/")[2] in NODES]


@of_each_topic
def test_a_topic_is_latched_or_not(hal: Hal, topic: Topic) -> None:
    latched = hal.driver.ask("latched", topic=hal.full(topic.name), kind=topic.type, timeout_s=10.0)
    assert latched == topic.latched


@pytest.fixture(scope="module")
def heard(running: Hal) -> Iterator[Mapping[str, Heard]]:
    """Two seconds of every topic, while nothing changes."""
    running.start_all()
    running.rest()
    found = {
        topic.name: running.driver.subscribe(running.full(topic.name), topic.type, latched=topic.latched)
        for topic in TOPICS
    }
    health = found["/diagnostics"]
    running.until("three of each", lambda: len(health.messages) >= 3 * len(NODES) + 1)
    running.until("all", lambda: all(len(each.messages) >= 12 for each in found.values()))
    yield found
    running.driver.leave(*found.values())


@of_each_topic
def test_a_topic_comes_at_its_rate(heard: Mapping[str, Heard], topic: Topic) -> None:
    """A busy machine leaves messages out, it adds none."""
    times = heard[topic.name].times_s[2:]  # the first may come late
    rate = (len(times) - 1) / (times[-1] - times[0])
    if topic.rate == HEALTH:
        rate /= len(NODES)
    low, high = {FRAMES: (12.0, 300.0), STATES: (2.5, 12.0), HEALTH: (0.4, 1.3)}[topic.rate]
    assert low < rate < high


def test_diagnostics_come_from_every_node_and_are_well(heard: Mapping[str, Heard], running: Hal) -> None:
    ok = running.by(Difference.LEVEL, ros1=0, ros2={"bytes": [0]})
    newest: dict[str, Message] = {}

    def well() -> bool:
        for message in list(heard["/diagnostics"].messages):
            newest.update({each["name"]: each for each in message["status"]})
        # edges that a busy machine takes late are a warning of those who see them
        nodes = ("Pressure", "Position") if running.state["missed"] else NODES
        return all(newest[node]["level"] == ok for node in nodes)

    # an alarm of a check before stays for some time
    running.until("all are well", well)
    assert set(newest) == set(NODES)
    tools = {value["value"] for each in newest.values() for value in each["values"] if value["key"] == "tool"}
    assert tools == {"verdin_gripper"}
    assert all(any(value["key"] == "tool" for value in each["values"]) for each in newest.values())
    port = str(running.world.port)
    assert {name: each["hardware_id"] for name, each in newest.items()} == {
        node: port if node == "Pressure" else "verdin_gripper" for node in NODES
    }


@pytest.mark.parametrize("name", SERVICES)
def test_a_service_has_its_type_and_its_server(hal: Hal, name: str) -> None:
    kind, node = SERVICES[name]
    hal.until("its server", lambda: {each for _, each in entities(hal, "service", name)} == {f"/{node}"})
    assert hal.driver.ask("service_type", name=hal.full(name)) == kind


@pytest.mark.parametrize("name", ACTIONS)
def test_an_action_has_its_type_and_its_server(hal: Hal, name: str) -> None:
    expect(hal, "action", name, {(ACTION, "/HALMain")})


@pytest.mark.parametrize("name", GRIPPER_CMD)
def test_the_actions_of_moveit_are_those_of_ros_2(hal: Hal, name: str) -> None:
    wanted = hal.by(Difference.GRIPPER_CMD, ros1=set(), ros2={(GRIPPER_CMD[name], "/HALMain")})
    expect(hal, "action", name, wanted)


def test_nothing_else_is_published_or_served(hal: Hal) -> None:
    own = {f"/{node}" for node in NODES}
    found = {
        (each["is"], each["name"])
        for each in hal.driver.graph()
        if each["node"] in own and each["is"] != "subscriber"
    }
    known = {("publisher", hal.full(topic.name)) for topic in TOPICS}
    known |= {("service", hal.full(name)) for name in SERVICES}
    known |= {("action", hal.full(name)) for name in (*ACTIONS, *GRIPPER_CMD)}
    assert found - known == set()


CONSTANTS = {
    "State": {
        "OFF": 0, "GRIPPING": 1, "GRIP_ERROR": 2, "GRIPPED": 3, "RELEASING": 4, "RELEASE_ERROR": 5, "STAND_BY": 6,
    },
    "Command": {"NONE": -1, "LOCK": 0, "UNLOCK": 1, "GRIP": 2, "RELEASE": 3, "CANCEL": 4, "QUIT": 5},
    "VacuumState": {"OFF": 0, "PENDING_ON": 1, "ON": 2},
    "CylinderState": {"RETRACTED": 0, "PENDING_EXTEND": 1, "EXTENDED": 2},
    "Outcome": {
        "NOT_EXECUTED": 0, "REJECTED": 1, "CANCELLED": 2, "FAILED": 3, "UNREACHABLE": 4, "SUCCEEDED": 5,
    },
}  # fmt: skip


@pytest.mark.parametrize("kind", CONSTANTS)
def test_the_integers_of_a_type_are_those_of_the_paper(hal: Hal, kind: str) -> None:
    assert hal.driver.ask("constants", kind=f"end_effector_msgs/{kind}") == CONSTANTS[kind]
