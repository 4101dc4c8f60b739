"""Every end of a goal: succeeded, failed, refused in words; its feedback; a second goal, and many at once."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from tests.acceptance.contract.driver import Driver
from tests.acceptance.contract.hal import ACTION, Hal

pytestmark = pytest.mark.ros
SEQUENCE = ["bottom_vacuum", "cylinder", "top_vacuum"]
GRIP_LINES = ["SODIMM_208", "SODIMM_210", "SODIMM_212"]
ATTEMPTS = 2
RUNNING = "{} is still running: one goal at a time. {} for its end."
CANCEL_OR_WAIT = "Cancel it, or wait"


def test_a_grip_succeeds_with_the_proof_of_each_step(resting: Hal) -> None:
    begun, edges = resting.since, resting.edges()
    result = resting.do("TriggerGrip")
    assert (result["outcome"], result["state"], result["state_name"], result["reason"]) == (
        5,
        3,
        "GRIPPED",
        "",
    )
    steps = [(step["actuator"], step["attempts"], step["confirmed"]) for step in result["steps"]]
    assert steps == [(name, 1, True) for name in SEQUENCE]
    assert all(0.05 < step["seconds"] < 2.5 for step in result["steps"])
    assert sum(step["seconds"] for step in result["steps"]) == pytest.approx(result["seconds"], abs=1.0)
    assert resting.edges()[len(edges) :] == [(line, 1) for line in GRIP_LINES]
    # the state comes over another connection than the result
    resting.until(
        "the state", lambda: any(each["held"] and each["lift_allowed"] for each in resting.after(begun))
    )


def test_the_feedback_of_a_grip_names_each_step_in_order(resting: Hal) -> None:
    goal = resting.send("TriggerGrip")
    goal.end()
    steps = [each for each in goal.feedback if each["state_name"] == "GRIPPING" and each["actuator"]]
    assert list(dict.fromkeys(each["actuator"] for each in steps)) == SEQUENCE
    assert {each["attempts_allowed"] for each in steps} == {ATTEMPTS}
    assert {each["attempt"] for each in steps} == {1}
    # NaN: it has just been confirmed
    left = [each["time_left_s"] for each in steps if not math.isnan(each["time_left_s"])]
    assert len(left) >= 3
    assert all(0.0 < seconds <= 2.5 for seconds in left), left


def test_every_change_of_a_grip_is_published_in_order(resting: Hal) -> None:
    begun = resting.since
    resting.do("TriggerGrip")
    resting.sees("GRIPPED", lambda state: state["state_name"] == "GRIPPED")
    rows = [(each["state"], each["command"], tuple(each["actuators"])) for each in resting.after(begun)]
    changes = [row for at, row in enumerate(rows) if at == 0 or row != rows[at - 1]]
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


def test_a_grip_while_gripped_is_refused(holding: Hal) -> None:
    edges = holding.edges()
    why = "A grip is accepted in STAND_BY only; the end-effector is GRIPPED."
    assert holding.refused("TriggerGrip") == why
    assert holding.edges() == edges


def test_an_unlock_while_gripped_is_refused(holding: Hal) -> None:
    why = "IL-01: unlock only in STAND_BY; the end-effector is GRIPPED."
    assert holding.refused("UnlockToolChanger") == why


def test_a_drop_succeeds_and_says_so_on_its_way(holding: Hal) -> None:
    edges = holding.edges()
    goal = holding.send("Drop")
    status, result = goal.end()
    assert (status, result["outcome_name"], result["state_name"]) == ("SUCCEEDED", "SUCCEEDED", "STAND_BY")
    assert (result["reason"], result["steps"]) == ("", [])
    assert result["seconds"] > 0.1
    assert "RELEASING" in {each["state_name"] for each in goal.feedback}
    assert holding.edges()[len(edges) :] == [(line, 0) for line in reversed(GRIP_LINES)]
    holding.sees("nothing held", lambda state: state["state_name"] == "STAND_BY" and not state["held"])


def test_a_drop_of_nothing_is_refused(resting: Hal) -> None:
    why = (
        "Nothing is held: a drop is accepted in GRIPPED, GRIP_ERROR and RELEASE_ERROR, and in STAND_BY while something "
        "is not proven to be gone; this is STAND_BY."
    )
    assert resting.refused("Drop") == why


def test_unlock_and_lock_succeed(resting: Hal) -> None:
    begun = resting.since
    result = resting.do("UnlockToolChanger")
    assert (result["state_name"], result["reason"]) == ("STAND_BY", "")
    resting.until(
        "UNLOCKED",
        lambda: any(
            each["tool_changer_name"] == "UNLOCKED" and each["unlock_output"] for each in resting.after(begun)
        ),
    )
    resting.do("LockToolChanger")
    resting.sees(
        "LOCKED", lambda state: state["tool_changer_name"] == "LOCKED" and not state["unlock_output"]
    )


def test_a_grip_while_unlocked_is_refused(resting: Hal) -> None:
    resting.do("UnlockToolChanger")
    why = "IL-05: the tool is not proven to be locked (its sensors say UNLOCKED)."
    assert resting.refused("TriggerGrip") == why


def test_a_grip_without_the_sensors_is_refused(resting: Hal) -> None:
    resting.choose("silent-after:0")
    resting.sees("the link is down", lambda state: not state["link_up"])
    assert resting.refused("TriggerGrip").startswith("IL-07: the sensor link")
    assert resting.state["state_name"] == "STAND_BY"


def test_a_grip_that_is_never_confirmed_fails_and_is_unwound(resting: Hal) -> None:
    resting.choose("never-confirms:bottom_vacuum")
    edges = resting.edges()
    goal = resting.send("TriggerGrip")
    status, result = goal.end()
    assert (status, result["outcome_name"]) == ("ABORTED", "FAILED")
    assert result["reason"].startswith("Bottom vacuum was not confirmed"), result["reason"]
    assert [(step["attempts"], step["confirmed"]) for step in result["steps"]] == [
        (ATTEMPTS, False),
        (0, False),
        (0, False),
    ]
    assert max(each["attempt"] for each in goal.feedback) == ATTEMPTS
    assert resting.edges()[len(edges) :] == [("SODIMM_208", 1), ("SODIMM_208", 0)] * ATTEMPTS
    state = resting.sees("the cause", lambda each: each["cause_actuator"] == "bottom_vacuum")
    assert state["reason"] == result["reason"]


@pytest.mark.parametrize("action", ["TriggerGrip", "Drop", "LockToolChanger", "UnlockToolChanger"])
def test_a_second_goal_is_refused_and_the_first_goes_on(resting: Hal, action: str) -> None:
    """It never takes the place of the first."""
    resting.choose("never-confirms:cylinder")
    first = resting.begin_goal("TriggerGrip", "the cylinder", lambda state: state["actuator"] == "cylinder")
    assert resting.refused(action) == RUNNING.format("TriggerGrip", CANCEL_OR_WAIT)
    assert first.ends == []
    first.cancel()
    assert first.end()[1]["outcome_name"] == "CANCELLED"


def test_a_goal_while_a_drop_runs_may_only_wait(holding: Hal) -> None:
    drop = holding.begin_goal("Drop", "RELEASING", lambda state: state["state_name"] == "RELEASING")
    assert holding.refused("TriggerGrip") == RUNNING.format("Drop", "Wait")
    assert drop.end()[0] == "SUCCEEDED"


def test_many_goals_at_once_are_all_answered_and_one_is_begun(resting: Hal) -> None:
    edges = resting.edges()
    goals = [resting.send("TriggerGrip") for _ in range(15)]
    ends = [goal.end()[1] for goal in goals]
    outcomes = [each["outcome_name"] for each in ends]
    assert (outcomes.count("SUCCEEDED"), outcomes.count("REJECTED")) == (1, 14)
    assert all(each["reason"] for each in ends if each["outcome_name"] == "REJECTED")
    assert resting.edges()[len(edges) :] == [(line, 1) for line in GRIP_LINES]


def test_a_client_that_vanishes_leaves_its_grip_to_go_on(resting: Hal, client: Callable[[], Driver]) -> None:
    begun, gone = resting.since, client()
    goal = gone.send(resting.full("TriggerGrip"), ACTION)
    resting.until("GRIPPING", lambda: any(each["state_name"] == "GRIPPING" for each in resting.after(begun)))
    gone.vanish()
    assert goal.ends == []
    assert resting.wait_for("GRIPPED")["held"]


@pytest.mark.nightly
def test_another_client_drops_what_one_that_vanished_has_gripped(
    holding: Hal, client: Callable[[], Driver]
) -> None:
    other = client()
    assert other.send(holding.full("Drop"), ACTION).end()[1]["outcome_name"] == "SUCCEEDED"
    holding.wait_for("STAND_BY")
