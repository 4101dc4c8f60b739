"""The state, its latching and its numbers; services; parameters; strangers; the ends of the nodes."""

from __future__ import annotations

import os
import signal
from typing import Any

import pytest

from end_effector_hal.description import load, profile_path
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_lab.demo._ros2 import FIVE, ONE
from end_effector_lab.demo._world import World
from tests.acceptance.ros2.conftest import System

GRIPPED, STAND_BY = EndEffectorState.GRIPPED, EndEffectorState.STAND_BY


def test_the_count_tells_changes_apart_from_repetitions(system: Any) -> None:
    system.do("TriggerGrip")
    system.do("Drop")
    system.until(
        "repetitions", lambda: [each.count for each in system.states[-3:]].count(system.state.count) == 3
    )
    counts = [each.count for each in system.states]
    assert counts == sorted(counts)
    assert len({each.since_us for each in system.states}) == 1


def test_a_late_subscriber_gets_the_newest_state_first(system: Any) -> None:
    from end_effector_msgs.msg import EndEffectorState as Message

    system.do("TriggerGrip")
    system.wait_for(GRIPPED)
    heard: list[Any] = []
    subscription = system.node.create_subscription(Message, "EndEffectorState", heard.append, system.latched)
    system.until("a state", lambda: heard)
    system.node.destroy_subscription(subscription)
    assert heard[0].held, "an old state would say that nothing is held"


def test_beside_each_integer_stands_its_name(system: Any) -> None:
    system.do("TriggerGrip")
    state = system.wait_for(GRIPPED)
    assert list(state.actuator_states) == ["ON", "EXTENDED", "ON"]
    assert list(state.evidence_names) == ["CONFIRMED"] * 3
    assert (state.tool, state.tool_changer_name, state.command_name) == ("verdin_gripper", "LOCKED", "NONE")


def test_pressures_are_absolute_pascal(system: Any) -> None:
    from sensor_msgs.msg import FluidPressure

    heard: list[Any] = []
    subscription = system.node.create_subscription(FluidPressure, "PressureSupply", heard.append, 10)
    system.until("pressures", lambda: len(heard) > 5)
    system.node.destroy_subscription(subscription)
    assert 500_000 < heard[-1].fluid_pressure < 900_000
    assert heard[-1].header.stamp.sec > 0


def test_an_actuator_is_refused_in_words_without_maintenance_of_what_is_gripped(system: Any) -> None:
    from std_srvs.srv import SetBool

    system.do("TriggerGrip")
    answer = system.call(SetBool, "SetBottomVacuum", SetBool.Request(data=False))
    assert not answer.success
    assert answer.message
    assert system.wait_for(GRIPPED).held


def test_a_reset_says_that_nothing_is_latched(system: Any) -> None:
    from std_srvs.srv import Trigger

    answer = system.call(Trigger, "ResetFaults", Trigger.Request())
    assert answer.success
    assert "No fault is latched" in answer.message


def test_the_parameters_are_read_only(system: Any) -> None:
    from rcl_interfaces.srv import SetParameters
    from rclpy.parameter import Parameter

    request = SetParameters.Request(
        parameters=[Parameter("description", value="/tmp/other.yaml").to_parameter_msg()]
    )
    answer = system.call(SetParameters, "Grip/set_parameters", request)
    assert not answer.results[0].successful


def test_every_node_tells_its_health(system: Any) -> None:
    from diagnostic_msgs.msg import DiagnosticArray

    heard: dict[str, Any] = {}

    def keep(message: Any) -> None:
        heard.update((each.name, each) for each in message.status)

    subscription = system.node.create_subscription(DiagnosticArray, "/diagnostics", keep, 10)
    system.until("all", lambda: set(heard) >= {"HALMain", "Grip", "ToolChange", "Pressure", "Position"})
    system.node.destroy_subscription(subscription)
    assert all(each.level == b"\0" for each in heard.values()), [each.message for each in heard.values()]


def test_frames_of_a_stranger_change_nothing_that_is_held(system: Any) -> None:
    from end_effector_msgs.msg import SensorFrame

    system.do("TriggerGrip")
    system.wait_for(GRIPPED)
    publisher = system.node.create_publisher(SensorFrame, "sensor_frame", 10)
    gone = SensorFrame(channels=["bottom"], values=[0], valid=[True])
    if system.five:

        def alarmed() -> bool:
            publisher.publish(gone)
            return any("sensor_frame" in alarm and "tests" in alarm for alarm in system.state.alarms)

        system.until("an alarm", alarmed)
    else:
        before = len(system.states)
        for _ in range(50):
            publisher.publish(gone)
        system.until("twenty states", lambda: len(system.states) > before + 20)
        assert all(each.lift_allowed for each in system.states[before:])
    assert system.state.held
    assert all(system.state.outputs)
    system.node.destroy_publisher(publisher)
    system.until("frames count again", lambda: system.state.lift_allowed)


@pytest.mark.parametrize(
    "number", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT], ids=lambda each: each.name
)
def test_a_held_part_outlives_the_nodes(system: Any, number: int) -> None:
    system.do("TriggerGrip")
    first = system.wait_for(GRIPPED).since_us
    system.kill_nodes(number)
    if number != signal.SIGKILL:
        assert {child.code for child in system.nodes.values()} == {0}
    system.start_nodes()
    system.until("another start", lambda: system.state.since_us != first and system.state.state == GRIPPED)
    assert system.state.held
    assert all(system.state.outputs)


@pytest.mark.parametrize("program", [ONE[0], *FIVE, "data_logger"])
def test_without_a_tool_it_says_how_to_name_one(running: Any, program: str) -> None:
    ended = running.run(program)
    assert ended.returncode == 2
    assert "description:=FILE" in ended.stderr
    assert "Traceback" not in ended.stderr


def test_an_argument_that_is_none_of_ros_is_told(running: Any) -> None:
    ended = running.run("hal", "--ros-args", "-p", "description")
    assert ended.returncode == 2
    assert "Traceback" not in ended.stderr


def test_a_description_with_a_fault_is_told_with_its_place(running: Any, tmp_path: Any) -> None:
    path = tmp_path / "tool.yaml"
    path.write_text("name: tool\nactuators: 3\n", encoding="utf-8")
    ended = running.run("hal", "--ros-args", "-p", f"description:={path}")
    assert ended.returncode == 2
    assert os.fspath(path) in ended.stderr
    assert "Traceback" not in ended.stderr


def test_two_nodes_of_one_name_are_refused(running: Any) -> None:
    ended = running.run("hal", "--ros-args", "-p", "profile:=verdin_gripper", "-r", "__node:=same")
    assert ended.returncode == 2
    assert "would be called same" in ended.stderr


@pytest.mark.parametrize("programs", [ONE, FIVE], ids=["one", "five"])
def test_a_tool_in_a_namespace(tmp_path: Any, programs: tuple[str, ...]) -> None:
    with World(load(profile_path()), "nominal", tmp_path) as world:
        left = System(world, tmp_path, programs)
        nodes = [left.start(program, "-r", "__ns:=/left") for program in programs]
        left.until(
            "a locked tool", lambda: any("tool changer: UNKNOWN -> LOCKED" in node.text() for node in nodes)
        )
        given = left.start("supervisor", "-p", "script:=lock; grip; drop", "-r", "__ns:=/left")
        left.until("its end", lambda: given.code is not None)
        assert given.code == 0, given.text()
        assert given.text().count("SUCCEEDED") == 3
