"""A cancel in every state: a grip is unwound, what is held stays held, a release completes."""

from __future__ import annotations

import pytest

from tests.acceptance.contract.differences import Difference
from tests.acceptance.contract.driver import Goal, Message
from tests.acceptance.contract.hal import ACTION, Hal

pytestmark = pytest.mark.ros
CANCELLED = "The grip was cancelled."


def takes_nothing(hal: Hal, goal: Goal) -> None:
    """A cancel that can change nothing: ROS 2 says so, ROS 1 has no answer to a cancel."""
    taken = goal.cancel()
    assert taken == hal.by(Difference.CANCEL_OF_RELEASE, ros1=None, ros2=False)


def unwound(hal: Hal, goal: Goal) -> Message:
    status, result = goal.end()
    wanted = hal.by(Difference.CANCELLED_STATUS, ros1="PREEMPTED", ros2="CANCELED")
    assert (status, result["outcome_name"], result["state_name"]) == (wanted, "CANCELLED", "STAND_BY")
    assert result["reason"] == CANCELLED
    assert result["seconds"] > 0.0
    return result


@pytest.mark.parametrize(
    ("actuator", "lines"),
    [
        ("top_vacuum", 3),
        pytest.param("bottom_vacuum", 1, marks=pytest.mark.nightly),
        pytest.param("cylinder", 2, marks=pytest.mark.nightly),
    ],
)
def test_a_cancel_at_each_step_of_a_grip_unwinds_in_reverse_order(
    resting: Hal, actuator: str, lines: int
) -> None:
    resting.choose(f"never-confirms:{actuator}")
    goal = resting.begin_goal(
        "TriggerGrip",
        actuator,
        lambda state: state["actuator"] == actuator and sum(state["outputs"]) == lines,
    )
    edges = resting.edges()
    assert goal.cancel() in (True, None)
    result = unwound(resting, goal)
    assert [step["confirmed"] for step in result["steps"]] == [at < lines - 1 for at in range(3)]
    off = [(line, 0) for line in ("SODIMM_212", "SODIMM_210", "SODIMM_208")[3 - lines :]]
    # nothing was confirmed at the first step: the result may come before the line is written
    resting.until("its edges", lambda: len(resting.edges()) == len(edges) + lines)
    assert resting.edges()[len(edges) :] == off
    resting.sees(
        "the cause", lambda state: (state["cause_name"], state["reason"]) == ("CANCELLED", CANCELLED)
    )


def test_a_cancel_of_everything_cancels_the_grip_that_runs(resting: Hal) -> None:
    resting.choose("never-confirms:cylinder")
    goal = resting.begin_goal("TriggerGrip", "GRIPPING", lambda state: state["actuator"] == "cylinder")
    resting.driver.ask("cancel_all", action=resting.full("TriggerGrip"), kind=ACTION)
    unwound(resting, goal)


def test_a_cancel_of_another_action_changes_nothing(resting: Hal) -> None:
    resting.choose("never-confirms:cylinder")
    goal = resting.begin_goal("TriggerGrip", "GRIPPING", lambda state: state["actuator"] == "cylinder")
    resting.driver.ask("cancel_all", action=resting.full("Drop"), kind=ACTION)
    resting.choose("nominal")
    assert goal.end()[1]["outcome_name"] in ("SUCCEEDED", "FAILED")


def test_a_cancel_of_a_grip_that_is_over_releases_nothing(resting: Hal) -> None:
    goal = resting.send("TriggerGrip")
    assert goal.end()[0] == "SUCCEEDED"
    edges = resting.edges()
    goal.cancel()
    resting.driver.ask("cancel_all", action=resting.full("TriggerGrip"), kind=ACTION)
    # whatever a cancel sets off comes before the answer to what is asked after it
    assert resting.refused("UnlockToolChanger")
    state = resting.wait_for("GRIPPED")
    assert (state["held"], resting.edges()) == (True, edges)
    assert len(goal.ends) == 1, "one end"


def test_a_cancel_of_a_drop_changes_nothing(holding: Hal) -> None:
    goal = holding.begin_goal("Drop", "RELEASING", lambda state: state["state_name"] == "RELEASING")
    takes_nothing(holding, goal)
    status, result = goal.end()
    assert (status, result["outcome_name"], result["state_name"]) == ("SUCCEEDED", "SUCCEEDED", "STAND_BY")


@pytest.mark.parametrize("action", ["UnlockToolChanger", "LockToolChanger"])
def test_a_cancel_of_a_tool_change_changes_nothing(resting: Hal, action: str) -> None:
    if action == "LockToolChanger":
        resting.do("UnlockToolChanger")
    word = {"UnlockToolChanger": "UNLOCK", "LockToolChanger": "LOCK"}[action]
    goal = resting.begin_goal(action, word, lambda state: state["command_name"] == word)
    takes_nothing(resting, goal)
    assert goal.end()[1]["outcome_name"] == "SUCCEEDED"


def test_a_cancel_by_time_that_overtakes_its_goal_counts_where_there_is_one(resting: Hal) -> None:
    """In ROS 1 a goal and its cancel come over two connections, in any order."""
    driver, edges = resting.driver, resting.edges()
    topic = resting.full("TriggerGrip/cancel")
    if resting.by(Difference.CANCEL_BY_TIME, ros1=False, ros2=True):
        assert topic not in {each["name"] for each in driver.graph()}
        return
    cancels = driver.ask("advertise", topic=topic, kind="actionlib_msgs/GoalID")
    goals = driver.ask(
        "advertise", topic=resting.full("TriggerGrip/goal"), kind="end_effector_msgs/EndEffectorActionGoal"
    )
    results = driver.subscribe(
        resting.full("TriggerGrip/result"), "end_effector_msgs/EndEffectorActionResult"
    )
    status = driver.subscribe(resting.full("TriggerGrip/status"), "actionlib_msgs/GoalStatusArray")
    cancel, goal = {"id": "overtaken"}, {"goal_id": {"id": "overtaken"}}
    for publisher, message in ((cancels, cancel), (goals, goal)):
        # a publisher that is new is connected in a moment; a goal that comes twice is answered once
        resting.until(
            "a connection", lambda of=publisher, what=message: driver.ask("publish", of=of, message=what)
        )
        driver.ask("publish", of=publisher, message=message)
        resting.until(
            "its place in the list",
            lambda: any(each["goal_id"]["id"] == "overtaken" for each in status.newest["status_list"]),
        )
    resting.until("a result", lambda: results.messages)
    (answer,) = results.messages
    assert answer["result"]["outcome_name"] == "NOT_EXECUTED"
    why = "The goal was cancelled before it was begun: it was not executed."
    assert (answer["result"]["reason"], answer["status"]["text"]) == (why, why)
    assert resting.edges() == edges
    driver.leave(results, status)
    for publisher in (cancels, goals):
        driver.ask("leave", of=publisher)


def test_a_goal_after_a_cancel_is_begun(resting: Hal) -> None:
    """No cancel covers a goal that comes after it."""
    resting.driver.ask("cancel_all", action=resting.full("TriggerGrip"), kind=ACTION)
    resting.do("TriggerGrip")
