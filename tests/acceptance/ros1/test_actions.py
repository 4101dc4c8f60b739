"""The four actions, as an action client sees them."""

from __future__ import annotations

import math
from typing import Any

import pytest

from end_effector_hal.vocabulary import EndEffectorState

pytestmark = pytest.mark.ros

PREEMPTED, SUCCEEDED, ABORTED, REJECTED = 2, 3, 4, 5
OUTCOME_REJECTED, OUTCOME_CANCELLED, OUTCOME_SUCCEEDED = 1, 2, 5


def test_grip_and_drop_with_feedback_and_result(system: Any) -> None:
    begun = len(system.states)
    goal = system.send("TriggerGrip")
    status, result = goal.result()
    assert (status, result.outcome, result.state) == (SUCCEEDED, OUTCOME_SUCCEEDED, EndEffectorState.GRIPPED)
    assert [(step.actuator, step.attempts, step.confirmed) for step in result.steps] == [
        ("bottom_vacuum", 1, True),
        ("cylinder", 1, True),
        ("top_vacuum", 1, True),
    ]
    assert all(0.1 < step.seconds < 5.0 for step in result.steps)
    assert sum(step.seconds for step in result.steps) == pytest.approx(result.seconds, abs=1.0)
    actuators = [message.actuator for message in goal.feedback if message.state == EndEffectorState.GRIPPING]
    assert list(dict.fromkeys(actuators)) == ["bottom_vacuum", "cylinder", "top_vacuum"]
    assert {message.attempts_allowed for message in goal.feedback if message.actuator} == {3}
    left = [message.time_left_s for message in goal.feedback if message.actuator]
    waits = [seconds for seconds in left if not math.isnan(seconds)]  # nan: it has just been confirmed
    assert len(waits) >= 3
    assert all(0.0 < seconds <= 5.0 for seconds in waits), left
    system.until("the state, over another connection", lambda: system.state.lift_allowed)
    assert system.state.held

    status, result = system.run("Drop")
    assert (status, result.outcome, result.state) == (SUCCEEDED, OUTCOME_SUCCEEDED, EndEffectorState.STAND_BY)
    assert not system.state.held

    def changes() -> list[int]:
        seen = [message.state for message in system.states[begun:]]
        return [state for i, state in enumerate(seen) if i == 0 or state != seen[i - 1]]

    system.until(
        "the last state, over another connection", lambda: changes()[-1] == EndEffectorState.STAND_BY
    )
    assert changes()[-4:] == [1, 3, 4, 6]


def test_every_change_of_a_grip_is_published(system: Any) -> None:
    begun = len(system.states)
    system.grip()
    rows = [(message.state, message.command, tuple(message.actuators)) for message in system.states[begun:]]
    changes = [row for i, row in enumerate(rows) if i == 0 or row != rows[i - 1]]
    assert changes[changes.index((1, 2, (0, 0, 0))) :] == [
        (1, 2, (0, 0, 0)),
        (1, 2, (1, 0, 0)),
        (1, 2, (2, 0, 0)),
        (1, 2, (2, 1, 0)),
        (1, 2, (2, 2, 0)),
        (1, 2, (2, 2, 1)),
        (1, 2, (2, 2, 2)),
        (3, -1, (2, 2, 2)),
    ]


def test_a_second_goal_is_rejected_with_a_reason_and_the_first_goes_on(system: Any) -> None:
    first = system.send("TriggerGrip")
    system.until("GRIPPING", lambda: system.state.state == EndEffectorState.GRIPPING)
    for action in ("TriggerGrip", "Drop", "LockToolChanger"):
        status, result = system.run(action)
        assert (status, result.outcome) == (REJECTED, OUTCOME_REJECTED)
        assert result.reason == (
            "TriggerGrip is still running: one goal at a time. Cancel it, or wait for its end."
        )
    assert first.result()[0] == SUCCEEDED


def test_a_grip_while_gripped_is_rejected_by_the_automaton(system: Any) -> None:
    system.grip()
    status, result = system.run("TriggerGrip")
    assert (status, result.outcome) == (REJECTED, OUTCOME_REJECTED)
    assert result.reason == "A grip is accepted in STAND_BY only; the end-effector is GRIPPED."
    assert system.state.state == EndEffectorState.GRIPPED


def test_a_drop_of_nothing_is_rejected(system: Any) -> None:
    status, result = system.run("Drop")
    assert (status, result.outcome) == (REJECTED, OUTCOME_REJECTED)
    assert result.reason.startswith("Nothing is held")


def test_a_cancel_in_the_middle_of_a_grip_unwinds(system: Any) -> None:
    system.world.choose("never-confirms:cylinder")
    goal = system.send("TriggerGrip")
    system.until("the cylinder", lambda: list(system.state.actuators) == [2, 1, 0])
    edges = len(system.edges())
    goal.handle.cancel()
    status, result = goal.result()
    assert (status, result.outcome, result.state) == (PREEMPTED, OUTCOME_CANCELLED, EndEffectorState.STAND_BY)
    assert result.reason == "The grip was cancelled."
    assert system.edges()[edges:] == [("SODIMM_210", 0), ("SODIMM_208", 0)]


def test_a_cancel_while_gripped_releases_nothing(system: Any) -> None:
    goal = system.send("TriggerGrip")
    goal.result()
    edges = len(system.edges())
    import rospy
    from actionlib_msgs.msg import GoalID

    publisher = rospy.Publisher("TriggerGrip/cancel", GoalID, queue_size=1)
    system.until("a connection", publisher.get_num_connections)
    publisher.publish(GoalID())
    rospy.sleep(0.5)
    assert system.state.state == EndEffectorState.GRIPPED
    assert system.edges()[edges:] == []


def test_a_cancel_while_releasing_changes_nothing(system: Any) -> None:
    system.grip()
    goal = system.send("Drop")
    system.until("RELEASING", lambda: system.state.state == EndEffectorState.RELEASING)
    goal.handle.cancel()
    status, result = goal.result()
    assert (status, result.state) == (SUCCEEDED, EndEffectorState.STAND_BY)


def test_unlock_and_lock(system: Any) -> None:
    begun = len(system.states)
    status, why = system.run("UnlockToolChanger")
    assert status == SUCCEEDED, why.reason
    system.until(
        "UNLOCKED",
        lambda: any(each.tool_changer == 2 and each.unlock_output for each in system.states[begun:]),
    )
    status, result = system.run("TriggerGrip")
    assert (status, result.reason[:5]) == (REJECTED, "IL-05")
    status, _ = system.run("LockToolChanger")
    assert status == SUCCEEDED
    system.until("LOCKED", lambda: system.state.tool_changer == 1 and not system.state.unlock_output)


def test_an_unlock_while_gripped_is_rejected(system: Any) -> None:
    system.grip()
    status, result = system.run("UnlockToolChanger")
    assert (status, result.outcome) == (REJECTED, OUTCOME_REJECTED)
    assert result.reason == "IL-01: unlock only in STAND_BY; the end-effector is GRIPPED."


def test_a_grip_is_rejected_while_the_link_is_dead(system: Any) -> None:
    system.world.choose("silent-after:0")
    system.until("the link to be down", lambda: not system.state.link_up)
    status, result = system.run("TriggerGrip")
    assert (status, result.outcome) == (REJECTED, OUTCOME_REJECTED)
    assert result.reason.startswith("IL-07: the sensor link")
    assert system.state.state == EndEffectorState.STAND_BY
    assert any("link" in alarm for alarm in system.state.alarms)


def test_a_link_that_dies_while_gripped_releases_nothing(system: Any) -> None:
    system.grip()
    edges = len(system.edges())
    system.world.choose("silent-after:0")
    system.until("UNKNOWN", lambda: list(system.state.evidence) == [0, 0, 0])
    assert system.state.state == EndEffectorState.GRIPPED
    assert not system.state.lift_allowed
    assert system.state.held
    assert system.edges()[edges:] == []


OF_A_BUSY_MACHINE = """
import time
import actionlib, rospy
from end_effector_msgs.msg import EndEffectorAction, EndEffectorGoal

rospy.init_node("busy", anonymous=True)
client = actionlib.SimpleActionClient("TriggerGrip", EndEffectorAction)
assert client.wait_for_server(rospy.Duration(30))
send = client.action_client.send_goal

def is_sent_and_returns_late(*arguments):
    handle = send(*arguments)
    time.sleep(0.03)
    return handle

client.action_client.send_goal = is_sent_and_returns_late
client.send_goal(EndEffectorGoal())
print(client.wait_for_result(rospy.Duration(20)), client.get_state())
"""


def test_a_refusal_waits_until_a_simple_client_listens(system: Any) -> None:
    system.grip()
    client = system.cli("python3", "-c", OF_A_BUSY_MACHINE)
    assert client.stdout.strip() == f"True {REJECTED}", client.stderr
