"""What MoveIt expects: ``gripper_cmd`` of both types over the goals that exist, and ``joint_states``."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import inf, nan
from typing import Any

import pytest

from end_effector_hal.vocabulary import EndEffectorState
from tests.acceptance.ros2.conftest import STROKE_MM, Sent, System

SUCCEEDED, CANCELED, ABORTED = 4, 5, 6
GRIPPED, GRIPPING, STAND_BY = EndEffectorState.GRIPPED, EndEffectorState.GRIPPING, EndEffectorState.STAND_BY
JOINT, CYLINDER = "verdin_gripper_joint", "verdin_gripper_cylinder_joint"

Send = Callable[..., Sent]


def gripper_goal(position: float, max_effort: float = 0.0) -> Any:
    from control_msgs.action import GripperCommand
    from control_msgs.msg import GripperCommand as Command

    return GripperCommand.Goal(command=Command(position=position, max_effort=max_effort))


def parallel_goal(position: float, max_effort: float = 0.0) -> Any:
    return joint_goal([JOINT], [position], [max_effort])


def joint_goal(names: list[str], positions: list[float], efforts: list[float]) -> Any:
    from control_msgs.action import ParallelGripperCommand
    from sensor_msgs.msg import JointState

    return ParallelGripperCommand.Goal(command=JointState(name=names, position=positions, effort=efforts))


@pytest.fixture
def clients(system: System) -> Iterator[dict[str, Any]]:
    """By the name that MoveIt makes: the controller's, then action_ns."""
    from control_msgs.action import GripperCommand, ParallelGripperCommand
    from rclpy.action import ActionClient

    kinds = {"gripper_controller": GripperCommand, "parallel_gripper_controller": ParallelGripperCommand}
    found = {name: ActionClient(system.node, kind, f"{name}/gripper_cmd") for name, kind in kinds.items()}
    assert all(client.wait_for_server(60.0) for client in found.values())
    yield found
    for client in found.values():  # by the thread that spins: it may be about to wait for this client
        task = system.executor.create_task(client.destroy)
        system.until("the client is destroyed", task.done)


@pytest.fixture(params=["gripper_controller", "parallel_gripper_controller"])
def ask(request: pytest.FixtureRequest, system: System, clients: dict[str, Any]) -> Send:
    """Send a position, and perhaps an effort, by one of the two types."""
    goal = {"gripper_controller": gripper_goal, "parallel_gripper_controller": parallel_goal}[request.param]
    return lambda *values: system.send_to(clients[request.param], goal(*values))


@pytest.fixture
def joints(system: System) -> Iterator[list[dict[str, float]]]:
    """Every message of joint_states."""
    from sensor_msgs.msg import JointState

    heard: list[dict[str, float]] = []

    def keep(message: Any) -> None:
        heard.append(dict(zip(message.name, message.position, strict=True)))

    subscription = system.node.create_subscription(JointState, "joint_states", keep, 100)
    system.until("joint_states", lambda: heard)
    yield heard
    system.node.destroy_subscription(subscription)


def position_of(message: Any) -> list[float]:
    """Where the joint stands: a number, or what the type has for one that is not known."""
    if hasattr(message, "state"):
        return list(message.state.position)
    return [] if message.position != message.position else [message.position]


def log(system: System) -> str:
    return system.nodes["hal_main" if system.five else "hal"].text()


def test_zero_grips_and_the_upper_limit_drops(system: System, ask: Send) -> None:
    goal = ask(0.0, 40.0)
    status, result = goal.result()
    assert (status, result.stalled, result.reached_goal) == (SUCCEEDED, True, True)
    assert position_of(result) == [0.0]
    assert not any(getattr(each, "stalled", False) for each in goal.feedback)
    assert [] in [position_of(each) for each in goal.feedback], "half gripped is no position"
    assert system.wait_for(GRIPPED).held
    status, result = ask(1.0).result()
    assert (status, result.stalled, result.reached_goal) == (SUCCEEDED, False, True)
    assert position_of(result) == [1.0]
    assert not system.wait_for(STAND_BY).held
    system.until("what is ignored", lambda: "ignored: the air sets force and speed" in log(system))


def test_a_position_that_is_reached_already_succeeds_at_once(system: System, ask: Send) -> None:
    status, result = ask(1.0).result()
    assert (status, result.stalled, result.reached_goal) == (SUCCEEDED, False, True)
    assert position_of(result) == [1.0]
    assert system.wait_for(STAND_BY).outputs == [False] * 3
    system.do("TriggerGrip")
    status, result = ask(0.0).result()
    assert (status, result.stalled, result.reached_goal) == (SUCCEEDED, True, True)
    assert position_of(result) == [0.0]
    assert system.wait_for(GRIPPED).held


def test_any_other_position_is_refused_in_the_log(system: System, ask: Send) -> None:
    system.do("TriggerGrip")
    for position in (0.5, 1.1, nan, -inf):
        status, result = ask(position).result()
        assert (status, result.stalled, result.reached_goal) == (ABORTED, False, False)
        words = f"REJECTED. The position {position:g} is not valid for this tool: 0 grips, 1 drops."
        system.until("the reason", lambda words=words: words in log(system))
    assert system.wait_for(GRIPPED).held


def test_a_goal_for_anything_but_the_one_joint_is_refused(system: System, clients: dict[str, Any]) -> None:
    system.do("TriggerGrip")
    for names in (
        [],
        ["other_joint"],
        [JOINT, JOINT],
        [f"j{each}" for each in range(10_000)],
        ["x" * 100_000],
    ):
        before = len(log(system))
        goal = joint_goal(names, [1.0], [])
        status, result = system.send_to(clients["parallel_gripper_controller"], goal).result()
        assert (status, result.reached_goal) == (ABORTED, False)
        system.until("the reason", lambda before=before: f"one position of {JOINT}" in log(system)[before:])
        assert len(log(system)) < before + 2000
    assert system.wait_for(GRIPPED).held


def test_a_second_goal_is_refused_whichever_action_runs(system: System, ask: Send) -> None:
    first = system.send("TriggerGrip")
    system.until("it grips", lambda: system.state.state == GRIPPING)
    status, result = ask(1.0).result()
    assert (status, result.stalled, result.reached_goal) == (ABORTED, False, False)
    system.until("the reason", lambda: "gripper_cmd: REJECTED. TriggerGrip is still running" in log(system))
    assert first.result()[0] == SUCCEEDED
    own = ask(1.0)
    system.until("it releases", lambda: system.state.state == EndEffectorState.RELEASING)
    status, result = system.send("TriggerGrip").result()
    assert "gripper_cmd is still running" in result.reason
    assert own.result()[0] == SUCCEEDED


def test_a_grip_is_cancelled_and_unwound_and_a_drop_is_not(system: System, ask: Send) -> None:
    system.choose("never-confirms:cylinder")
    goal = ask(0.0)
    system.until("the cylinder", lambda: system.state.actuator == "cylinder")
    assert goal.cancel()
    status, result = goal.result()
    assert (status, result.stalled, result.reached_goal) == (CANCELED, False, False)
    assert not any(system.wait_for(STAND_BY).outputs)
    system.put_down()
    system.do("TriggerGrip")
    drop = ask(1.0)
    system.until("it releases", lambda: system.state.state == EndEffectorState.RELEASING)
    assert not drop.cancel()
    assert drop.result()[0] == SUCCEEDED


def test_a_grip_that_the_sensors_do_not_prove_is_no_success(system: System, clients: dict[str, Any]) -> None:
    system.choose("never-confirms:bottom_vacuum")
    status, result = system.send_to(clients["gripper_controller"], gripper_goal(0.0)).result()
    assert (status, result.stalled, result.reached_goal) == (ABORTED, False, False)
    system.until("the reason", lambda: "gripper_cmd: FAILED. " in log(system))


def test_joint_states_has_a_joint_only_while_its_position_is_proven(
    system: System, joints: list[dict[str, float]]
) -> None:
    released, gripped = {CYLINDER: 0.0, JOINT: 1.0}, {CYLINDER: STROKE_MM / 1000, JOINT: 0.0}
    system.until("released", lambda: joints[-1] == released)
    begun = len(joints)
    system.do("TriggerGrip")
    system.until("gripped", lambda: joints[-1] == gripped)
    way = [each for each, before in zip(joints[begun:], joints[begun - 1 :], strict=False) if each != before]
    # the bottom vacuum is first, then the cylinder leaves its end, and the top vacuum is last
    assert way == [{CYLINDER: 0.0}, {CYLINDER: STROKE_MM / 1000}, gripped]
    assert list(system.state.positions)[1] == STROKE_MM / 1000
    assert {str(each) for each in system.state.positions} == {"nan", str(STROKE_MM / 1000)}


def test_joint_states_are_repeated(system: System, joints: list[dict[str, float]]) -> None:
    system.until("ten", lambda: len(joints) > 10)
    assert joints[-1] == joints[-2]


def test_without_control_msgs_the_two_actions_are_not_offered_and_the_log_says_so(
    tmp_path: Any, running: System
) -> None:
    (tmp_path / "control_msgs").mkdir()
    (tmp_path / "control_msgs" / "__init__.py").touch()
    node = running.start(
        "hal_main", "-r", "__ns:=/bare", "-p", "connect:=true", env={"PYTHONPATH": str(tmp_path)}
    )
    names = ("gripper_controller/gripper_cmd", "parallel_gripper_controller/gripper_cmd")
    running.until("the log", lambda: all(f"{name} is not offered" in node.text() for name in names))

    def offered() -> set[str]:
        from rclpy.action import get_action_names_and_types

        return {name for name, _ in get_action_names_and_types(running.node) if name.startswith("/bare/")}

    running.until("the others", lambda: len(offered()) == 4)
    assert "/bare/TriggerGrip" in offered()
    node.end()
    assert node.code == 0
