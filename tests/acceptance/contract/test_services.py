"""Services: maintenance, arming, resets and their refusals; parameters do not change."""

from __future__ import annotations

import pytest

from tests.acceptance.contract.differences import Difference
from tests.acceptance.contract.hal import NODES, Hal

pytestmark = pytest.mark.ros
BOTH = "IL-04: locked and unlocked were both on, or both off, for 0.5 s: a sensor fault, until a reset."


@pytest.mark.parametrize(
    ("service", "line"),
    [("SetBottomVacuum", "SODIMM_208"), ("SetCylinder", "SODIMM_210"), ("SetTopVacuum", "SODIMM_212")],
)
def test_an_actuator_is_driven_and_proven(resting: Hal, service: str, line: str) -> None:
    edges = resting.edges()
    success, message = resting.call(service, data=True)
    assert (success, "sensor" in message) == (True, True), message
    assert resting.call(service, data=False)[0]
    assert resting.edges()[len(edges) :] == [(line, 1), (line, 0)]
    resting.sees("its end", lambda state: not state["maintenance"])


def test_maintenance_stands_in_the_state_and_refuses_goals(resting: Hal) -> None:
    assert resting.call("SetCylinder", data=True)[0]
    try:
        state = resting.sees("maintenance", lambda each: each["maintenance"])
        assert state["outputs"] == [False, True, False]
        assert 0 < state["time_left_s"] <= 30
        resting.until("an alarm", lambda: resting.alarmed("Maintenance: Cylinder active"))
        assert resting.refused("TriggerGrip").startswith("IL-12: a grip is refused during maintenance.")
        assert resting.refused("UnlockToolChanger").startswith("IL-01")
    finally:
        assert resting.call("SetCylinder", data=False)[0]
    resting.sees("its end", lambda each: not each["maintenance"])


@pytest.mark.parametrize("service", ["SetBottomVacuum", "SetCylinder", "SetTopVacuum"])
def test_no_actuator_is_driven_by_hand_while_a_part_is_held(holding: Hal, service: str) -> None:
    edges = holding.edges()
    success, message = holding.call(service, data=False)
    assert (success, message.startswith("IL-12")) == (False, True), message
    assert holding.edges() == edges


def test_the_tool_changer_is_not_unlocked_by_hand_while_a_part_is_held(holding: Hal) -> None:
    edges = holding.edges()
    why = "IL-01: unlock only in STAND_BY; the end-effector is GRIPPED."
    success, message = holding.call("SetToolChanger", data=True)
    assert (success, why in message) == (False, True), message
    assert holding.edges() == edges


def test_the_tool_changer_is_driven_by_hand(resting: Hal) -> None:
    assert resting.call("SetToolChanger", data=True)[0]
    resting.sees("UNLOCKED", lambda state: state["tool_changer_name"] == "UNLOCKED")
    assert resting.call("SetToolChanger", data=False)[0]
    resting.sees("LOCKED", lambda state: state["tool_changer_name"] == "LOCKED")


def test_arming_is_refused_where_a_sensor_shows_the_stand(resting: Hal) -> None:
    why = "A sensor (in_stand) shows where the tool is: an unlock needs no arming."
    assert resting.call("ArmToolChanger") == (False, why)


def test_a_reset_says_that_nothing_is_latched(resting: Hal) -> None:
    assert resting.call("ResetFaults") == (
        True,
        "No fault is latched any more. GRIP_ERROR or RELEASE_ERROR needs a Drop, or after a loss a resume.",
    )


def test_a_lost_grip_is_resumed_once_it_is_confirmed_again(holding: Hal) -> None:
    edges = holding.edges()
    assert holding.call("ResumeGrip") == (
        False,
        "Nothing was lost: a resume is accepted in GRIP_ERROR only; the end-effector is GRIPPED.",
    )
    holding.choose("shows:top_vacuum:-30")
    holding.sees("the loss", lambda state: state["state_name"] == "GRIP_ERROR")
    accepted, why = holding.call("ResumeGrip")
    assert (accepted, why.startswith("Top vacuum is not confirmed again: ")) == (False, True), why
    holding.choose("nominal")
    holding.until("a resume", lambda: holding.call("ResumeGrip")[0])
    holding.sees("GRIPPED", lambda state: state["state_name"] == "GRIPPED" and state["held"])
    assert holding.edges() == edges, "no line has moved"


def test_a_stop_is_latched_until_a_reset_and_drops_nothing(holding: Hal) -> None:
    edges = holding.edges()
    accepted, why = holding.call("StopTool")
    assert accepted
    assert why.startswith("The stop is latched")
    stopped = holding.sees("the stop", lambda state: any("was stopped" in each for each in state["alarms"]))
    assert stopped["held"]
    assert holding.edges() == edges, "what is held stays held"
    holding.do("Drop")
    assert holding.refused("TriggerGrip").startswith("IL-13: the tool was stopped")
    assert holding.call("ResetFaults")[0]
    holding.sees("the reset", lambda state: not any("was stopped" in each for each in state["alarms"]))


@pytest.mark.parametrize("lie", ["unlocked-shows:tool_changer:1", "locked-shows:tool_changer:0"])
def test_a_sensor_fault_is_latched_until_a_reset_with_right_sensors(resting: Hal, lie: str) -> None:
    edges = resting.edges()
    resting.choose(lie)
    resting.sees("FAULT", lambda state: state["tool_changer_name"] == "FAULT" and BOTH in state["alarms"])
    why = f"The sensors of the tool changer still contradict each other. {BOTH}"
    assert resting.call("ResetFaults") == (False, why)
    for action in ("UnlockToolChanger", "TriggerGrip"):
        assert resting.refused(action)
    resting.choose("nominal")
    resting.sees("right sensors", lambda state: state["tool_position_name"] == "LOCKED")
    assert resting.refused("UnlockToolChanger") == f"The tool changer is FAULT. {BOTH}", "it is latched"
    resting.until("a reset", lambda: resting.call("ResetFaults")[0])
    resting.sees(
        "LOCKED", lambda state: state["tool_changer_name"] == "LOCKED" and BOTH not in state["alarms"]
    )
    assert resting.edges() == edges, "no line has moved"


@pytest.mark.parametrize("node", NODES)
def test_another_tool_cannot_be_named_while_a_node_runs(hal: Hal, node: str) -> None:
    path = str(hal.world.description_path.absolute())
    assert hal.driver.ask("parameter", node=f"/{node}", name="description") == path
    taken, _ = hal.driver.ask("set_parameter", node=f"/{node}", name="description", value="/tmp/other.yaml")
    try:
        assert taken == hal.by(Difference.PARAMETERS, ros1=True, ros2=False)
        assert hal.state["tool"] == "verdin_gripper"
    finally:
        hal.driver.ask("set_parameter", node=f"/{node}", name="description", value=path)
