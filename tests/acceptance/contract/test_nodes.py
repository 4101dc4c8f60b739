"""Nodes that hang, die or end, and are back: what they held stays held, no result lies, nothing given up is executed.

In one process (ROS 2) the nodes die together; a check of a single node then expects that of all of them.
"""

from __future__ import annotations

import signal

import pytest

from tests.acceptance.contract.differences import Difference
from tests.acceptance.contract.driver import Goal
from tests.acceptance.contract.hal import NODES, Hal
from tests.support.nightly import first_of

pytestmark = pytest.mark.ros
GRIP_LINES = ["SODIMM_208", "SODIMM_210", "SODIMM_212"]


def together(hal: Hal) -> bool:
    """Whether all nodes are one process."""
    return hal.one and hal.by(Difference.PROCESSES, ros1=False, ros2=True)


def back(hal: Hal, node: str) -> None:
    """Start it again, and wait until it is heard and served."""
    begun, before = hal.since, hal.state["since_us"]
    hal.start_all()
    if node == "HALMain" or hal.one:
        hal.until("another HALMain", lambda: any(each["since_us"] != before for each in hal.after(begun)))
        hal.serve()


def at_the_last_step(hal: Hal) -> Goal:
    hal.choose("never-confirms:top_vacuum")
    return hal.begin_goal("TriggerGrip", "the last step", lambda state: state["outputs"] == [True] * 3)


def decides_again(hal: Hal) -> None:
    """A node that has hung comes to what is asked of it now, after all that was asked before; at first too late."""
    hal.wait_for("GRIPPED")
    why = "A grip is accepted in STAND_BY only; the end-effector is GRIPPED."
    hal.until("an answer", lambda: hal.refused("TriggerGrip") == why)


SEEN = {
    "Pressure": ("the link is down", lambda state: not state["link_up"]),
    "Position": ("no positions", lambda state: state["tool_position_name"] == "UNKNOWN"),
    "Grip": (
        "OFF",
        lambda state: (
            (state["state_name"], state["tool_changer_name"], state["lift_allowed"])
            == ("OFF", "UNKNOWN", False)
        ),
    ),
}
"""What the state says when a node has gone; of ToolChange it says nothing."""


@pytest.mark.parametrize("node", first_of(sorted(NODES, key=lambda node: node != "Grip")))
def test_a_node_that_is_killed_while_a_part_is_held_is_back_and_moves_no_line(
    holding: Hal, node: str
) -> None:
    edges, begun, first = holding.edges(), holding.since, holding.state["since_us"]
    holding.kill(node)
    if node in SEEN and not together(holding):
        what, seen = SEEN[node]
        holding.sees(what, seen)
    back(holding, node)
    holding.sees("GRIPPED", lambda state: state["state_name"] == "GRIPPED" and state["lift_allowed"])
    assert {each["held"] for each in holding.after(begun) if each["since_us"] == first} <= {True}
    assert holding.edges() == edges
    holding.sees(
        "everything known",
        lambda state: (
            (state["tool_changer_name"], state["tool_position_name"], state["stale"])
            == ("LOCKED", "LOCKED", [])
        ),
    )


@pytest.mark.parametrize("number", first_of([signal.SIGTERM, signal.SIGINT]), ids=lambda each: each.name)
def test_a_node_ends_in_good_order_and_what_is_held_stays_held(holding: Hal, number: signal.Signals) -> None:
    edges = holding.edges()
    codes = {node: holding.kill(node, number) for node in (NODES[:1] if holding.one else reversed(NODES))}
    assert set(codes.values()) == {0}
    assert holding.state["state_name"] == "OFF", "the last word"
    assert (holding.state["held"], holding.state["lift_allowed"]) == (True, False)
    back(holding, "HALMain")
    holding.sees("GRIPPED", lambda state: state["state_name"] == "GRIPPED" and state["held"])
    assert holding.edges() == edges


@pytest.mark.parametrize("number", first_of([signal.SIGTERM, signal.SIGINT]), ids=lambda each: each.name)
def test_a_goal_in_flight_is_answered_when_hal_main_ends(resting: Hal, number: signal.Signals) -> None:
    goal = at_the_last_step(resting)
    resting.signal("HALMain", number)
    status, result = goal.end()
    assert (status, result["outcome_name"], result["state_name"]) == ("ABORTED", "UNREACHABLE", "GRIPPING")
    assert result["reason"] == (
        "HALMain is ending while TriggerGrip was at work, and does not see its end. "
        "What is held stays held. See EndEffectorState once HALMain is back."
    )
    resting.until("its end", lambda: resting.children[resting.program("HALMain")].code == 0)
    assert "Traceback" not in resting.said("HALMain")
    resting.choose("nominal")
    back(resting, "HALMain")
    if not together(resting):
        resting.wait_for("GRIPPED")  # the grip went on without it


@pytest.mark.nightly
def test_a_goal_of_a_hal_main_that_is_killed_never_succeeds(resting: Hal) -> None:
    goal = at_the_last_step(resting)
    resting.kill("HALMain")
    resting.choose("nominal")
    back(resting, "HALMain")
    resting.wait_for("GRIPPED", "STAND_BY", "GRIP_ERROR")
    if resting.by(Difference.LOST_GOAL, ros1=True, ros2=False):
        resting.until("a loss", lambda: goal.ends)
    assert [end for end in goal.ends if end[1] is not None] == [], "no result"


def test_a_goal_ends_when_its_node_dies_and_the_tool_is_unwound(resting: Hal) -> None:
    goal = at_the_last_step(resting)
    edges = resting.edges()
    resting.kill("Grip")
    if not together(resting):
        status, result = goal.end()
        assert (status, result["outcome_name"]) == ("ABORTED", "UNREACHABLE")
        assert result["reason"] == (
            "The node Grip has gone: it is unknown whether the command was executed. "
            "Read the state before the next one."
        )
    resting.until("the last will", lambda: len(resting.edges()) >= len(edges) + 3)
    assert resting.edges()[len(edges) :] == [(line, 0) for line in reversed(GRIP_LINES)]
    resting.choose("nominal")
    back(resting, "Grip")
    resting.wait_for("STAND_BY", "GRIP_ERROR")


def test_a_command_to_a_node_that_hangs_is_never_executed(holding: Hal) -> None:
    """The client was told that the drop was given up: it must not happen when the node goes on."""
    if together(holding):
        return  # whoever hangs, HALMain hangs with it: there is nobody who could give the command up
    edges = holding.edges()
    holding.stop("Grip")
    try:
        holding.sees("OFF", lambda state: state["state_name"] == "OFF")
        assert holding.alarmed("Grip is silent")
        assert (holding.state["held"], holding.state["lift_allowed"]) == (True, False)
        # those that pile up are in nobody's way either
        drops = [holding.send("Drop") for _ in range(3)]
        ends = [drop.end() for drop in drops]
    finally:
        holding.signal("Grip", signal.SIGCONT)
    status = holding.by(Difference.REFUSED_GOAL, ros1="REJECTED", ros2="ABORTED")
    assert {(each, result["outcome_name"]) for each, result in ends} == {(status, "UNREACHABLE")}
    assert {result["reason"] for _, result in ends} == {"The node Grip does not answer."}
    decides_again(holding)
    assert holding.edges() == edges


@pytest.mark.nightly
def test_more_goals_than_are_kept_are_refused_in_words(holding: Hal) -> None:
    if together(holding):
        return  # as above
    holding.stop("Grip")
    try:
        drops = [holding.send("Drop") for _ in range(12)]
        refused = "10 goals of Drop wait for their answer: no more are accepted. Wait for their end."
        reasons = [drop.end()[1]["reason"] for drop in drops]
    finally:
        holding.signal("Grip", signal.SIGCONT)
    assert reasons.count(refused) == 2
    assert reasons.count("The node Grip does not answer.") == 10
    decides_again(holding)
