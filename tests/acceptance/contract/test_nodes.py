"""Nodes that hang, die or end, and are back: what they held stays held, no result lies, nothing given up is executed.

HALMain runs the tool: its death is that of the HAL. The death of any other node ends nothing but its own topics and
services. In one process (ROS 2) all nodes die together.
"""

from __future__ import annotations

import signal

import pytest

from tests.acceptance.contract.differences import Difference
from tests.acceptance.contract.driver import Goal, Heard, Message
from tests.acceptance.contract.hal import NODES, Hal
from tests.support.nightly import first_of

pytestmark = pytest.mark.ros
GRIP_LINES = ["SODIMM_208", "SODIMM_210", "SODIMM_212"]


def together(hal: Hal) -> bool:
    """Whether all nodes are one process."""
    return hal.one and hal.by(Difference.PROCESSES, ros1=False, ros2=True)


def reported(heard: Heard) -> list[Message]:
    """What the nodes have reported in ``/diagnostics``."""
    return [each for message in list(heard.messages) for each in message["status"]]


def back(hal: Hal, node: str) -> None:
    """Start it again, and wait until it is heard and served."""
    begun, before = hal.since, hal.state["since_us"]
    heard = hal.driver.subscribe("/diagnostics", "diagnostic_msgs/DiagnosticArray")
    hal.start_all()
    if node == "HALMain" or hal.one:
        hal.until("another HALMain", lambda: any(each["since_us"] != before for each in hal.after(begun)))
        hal.serve()
    hal.until(node, lambda: any(f"/{each['name']}" == hal.full(node) for each in reported(heard)))
    hal.driver.leave(heard)


def at_the_last_step(hal: Hal) -> Goal:
    hal.choose("never-confirms:top_vacuum")
    return hal.begin_goal("TriggerGrip", "the last step", lambda state: state["outputs"] == [True] * 3)


@pytest.mark.parametrize("node", first_of(sorted(NODES, key=lambda node: node != "HALMain")))
def test_a_node_that_is_killed_while_a_part_is_held_is_back_and_moves_no_line(
    holding: Hal, node: str
) -> None:
    edges, begun, first = holding.edges(), holding.since, holding.state["since_us"]
    holding.kill(node)
    back(holding, node)
    holding.sees("GRIPPED", lambda state: state["state_name"] == "GRIPPED" and state["lift_allowed"])
    if node != "HALMain" and not together(holding):
        # on a busy machine a reading may be stale for a moment
        heard = [each for each in holding.after(begun) if not each["stale"]]
        noticed = [each for each in heard if (each["state_name"], each["lift_allowed"]) != ("GRIPPED", True)]
        assert heard
        assert not noticed, "the tool does not notice the death of a face"
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
        "HALMain is ending while TriggerGrip was at work, and does not see its end. The line arbiter deactivates "
        "Top vacuum, then Cylinder, then Bottom vacuum, as declared. See EndEffectorState once HALMain is back."
    )
    resting.until("its end", lambda: resting.children[resting.program("HALMain")].code == 0)
    assert "Traceback" not in resting.said("HALMain")
    resting.choose("nominal")
    back(resting, "HALMain")
    resting.wait_for("STAND_BY", "GRIP_ERROR")


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


def test_a_grip_is_unwound_when_the_node_that_runs_the_tool_dies(resting: Hal) -> None:
    at_the_last_step(resting)
    edges = resting.edges()
    resting.kill("HALMain")
    resting.until("the last will", lambda: len(resting.edges()) >= len(edges) + 3)
    assert resting.edges()[len(edges) :] == [(line, 0) for line in reversed(GRIP_LINES)]
    resting.choose("nominal")
    back(resting, "HALMain")
    resting.wait_for("STAND_BY", "GRIP_ERROR")


def test_a_service_of_a_hal_that_hangs_is_never_executed(resting: Hal) -> None:
    """The caller was told that there was no answer: the actuator must not move when the HAL goes on."""
    if together(resting):
        return  # the service hangs as well
    edges = resting.edges()
    resting.stop("HALMain")
    try:
        accepted, why = resting.call("SetCylinder", data=True)
    finally:
        resting.signal("HALMain", signal.SIGCONT)
    assert (accepted, why) == (
        False,
        "The HAL does not answer: it is unknown whether the command was executed.",
    )
    resting.wait_for("STAND_BY")
    resting.until("a later call is executed", lambda: resting.call("ResetFaults")[0])
    assert resting.edges() == edges
