"""Every end of a goal, in ROS 2: with words, and with the status that its outcome has there."""

from __future__ import annotations

from typing import Any

from end_effector_hal.vocabulary import EndEffectorState

SUCCEEDED, CANCELED, ABORTED = 4, 5, 6
GRIPPED, GRIPPING, STAND_BY = EndEffectorState.GRIPPED, EndEffectorState.GRIPPING, EndEffectorState.STAND_BY


def test_grip_and_drop_with_feedback_and_result(system: Any) -> None:
    goal = system.send("TriggerGrip")
    status, result = goal.result()
    assert result.reason == ""
    assert (status, result.outcome_name, result.state_name) == (SUCCEEDED, "SUCCEEDED", "GRIPPED")
    assert [step.actuator for step in result.steps] == ["bottom_vacuum", "cylinder", "top_vacuum"]
    assert all(step.confirmed and step.attempts == 1 for step in result.steps)
    assert {each.state_name for each in goal.feedback} >= {"GRIPPING"}
    state = system.wait_for(GRIPPED)
    assert (state.held, state.lift_allowed, state.state_name) == (True, True, "GRIPPED")
    system.do("Drop")
    assert not system.wait_for(STAND_BY).held


def test_a_goal_that_is_refused_says_why(system: Any) -> None:
    system.do("TriggerGrip")
    status, result = system.send("TriggerGrip").result()
    assert (status, result.outcome_name) == (ABORTED, "REJECTED")
    assert result.reason


def test_a_second_goal_is_refused_and_the_first_goes_on(system: Any) -> None:
    first = system.send("TriggerGrip")
    system.until("it grips", lambda: system.state.state == GRIPPING)
    status, result = system.send("Drop").result()
    assert (status, result.outcome_name) == (ABORTED, "REJECTED")
    assert "TriggerGrip is still running" in result.reason
    assert first.result()[0] == SUCCEEDED


def test_a_grip_is_cancelled_and_what_it_activated_is_released(system: Any) -> None:
    system.choose("never-confirms:cylinder")
    goal = system.send("TriggerGrip")
    system.until("the cylinder", lambda: system.state.actuator == "cylinder")
    assert goal.cancel()
    status, result = goal.result()
    assert (status, result.outcome_name) == (CANCELED, "CANCELLED")
    assert result.reason
    assert not any(system.wait_for(STAND_BY).outputs)


def test_a_grip_that_is_never_confirmed_fails_with_its_reason(system: Any) -> None:
    system.choose("never-confirms:bottom_vacuum")
    status, result = system.send("TriggerGrip").result()
    assert (status, result.outcome_name) == (ABORTED, "FAILED")
    assert "bottom vacuum" in result.reason.lower()


def test_a_drop_cannot_be_cancelled(system: Any) -> None:
    system.do("TriggerGrip")
    goal = system.send("Drop")
    system.until("it releases", lambda: system.state.state == EndEffectorState.RELEASING)
    assert not goal.cancel()
    assert goal.result()[0] == SUCCEEDED


def test_many_goals_at_once_are_all_answered(system: Any) -> None:
    goals = [system.send("TriggerGrip") for _ in range(15)]
    ends = [goal.result()[1].outcome_name for goal in goals]
    assert ends.count("SUCCEEDED") == 1
    assert set(ends) == {"SUCCEEDED", "REJECTED"}
    assert all(goal.result()[1].reason for goal, end in zip(goals, ends, strict=True) if end == "REJECTED")


def test_a_client_that_vanishes_leaves_its_grip_to_go_on(system: Any) -> None:
    from end_effector_msgs.action import EndEffector
    from rclpy.action import ActionClient

    client = ActionClient(system.node, EndEffector, "TriggerGrip")
    assert client.wait_for_server(60.0)
    client.send_goal_async(EndEffector.Goal())
    system.until("it grips", lambda: system.state.state == GRIPPING)
    client.destroy()
    assert system.wait_for(GRIPPED).held
