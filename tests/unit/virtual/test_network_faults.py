"""What a network does between the line arbiter and a device at an address, in virtual time."""

from __future__ import annotations

import pytest

from end_effector_hal.codecs import load_tool
from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_lab.testbench import offered_faults, parse_scenario
from end_effector_lab.trials import Moment, cells_of
from end_effector_lab.virtual import VirtualTool
from tests.support.places import ROOT
from tests.unit.virtual.test_unread_outputs import until

GRIPPED, RELEASE_ERROR, STAND_BY = (
    EndEffectorState.GRIPPED,
    EndEffectorState.RELEASE_ERROR,
    EndEffectorState.STAND_BY,
)
LIFT = "modbus:1/0x0000"
NETWORK = {"closed-after", "cut-answers"}


@pytest.fixture(scope="module")
def tool() -> Description:
    return load_tool(ROOT / "examples/tools/remote_io/end_effector.yaml")


def test_only_a_device_at_an_address_has_the_faults_of_a_network(tool: Description) -> None:
    assert {each.name for each in offered_faults(tool)} >= NETWORK
    wired = load_tool(ROOT / "examples/tools/gripper_2f85/end_effector.yaml")
    assert NETWORK.isdisjoint(each.name for each in offered_faults(wired))
    with pytest.raises(UsageError) as refused:
        parse_scenario("closed-after:0", wired)
    assert "is a fault of a network link" in refused.value.what


def test_the_matrix_has_a_closed_port_a_reset_and_three_delays(tool: Description) -> None:
    faults = {each.fault for each in cells_of(tool, [Moment("rest", 0, "rest", ())])}
    assert faults >= {
        "closed-after:0", "cut-answers:0.2", "cut-answers:1", "late-answers:50", "late-answers:500",
        "late-answers:5000",
    }  # fmt: skip


@pytest.mark.parametrize("fault", ["closed-after:0", "cut-answers:1", "silent-after:0", "late-answers:5000"])
def test_what_is_held_stays_held_and_a_drop_is_done_when_the_network_is_back(
    tool: Description, fault: str
) -> None:
    played = VirtualTool(tool)
    until(played, STAND_BY)
    played.run(1.0)
    assert played.command("grip").accepted
    until(played, GRIPPED)
    played.choose(fault)
    played.run(5.0)
    assert (played.status.ee, played.status.lift_allowed) == (GRIPPED, False)
    assert all(played.levels.values())
    assert played.command("drop").accepted
    played.run(15.0)
    assert played.status.ee is RELEASE_ERROR, "nothing is proven"
    assert any("no device acknowledges it" in text for text in played.status.alarm_texts)
    assert played.levels[LIFT], "the lift waits for the cup's acknowledgement"
    played.choose("nominal")
    played.run(4.0)
    assert not any(played.levels.values())
    assert played.command("drop").accepted
    until(played, STAND_BY)


def test_an_activation_is_given_up_while_the_port_is_closed(tool: Description) -> None:
    """Nothing moves unexpectedly when the network is back."""
    played = VirtualTool(tool)
    until(played, STAND_BY)
    played.run(1.0)
    played.choose("closed-after:0")
    assert played.command("grip").accepted, "its readings are not stale yet"
    played.run(60.0)
    assert played.edges == []
    played.choose("nominal")
    played.run(10.0)
    assert played.edges == []
