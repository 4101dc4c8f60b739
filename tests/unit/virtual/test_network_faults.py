"""What a network does between the line arbiter and a device at an address, in virtual time."""

from __future__ import annotations

from pathlib import Path

import pytest

from end_effector_hal.codecs import load_tool
from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_lab.testbench import offered_faults, parse_scenario
from end_effector_lab.trials import Moment, case_from_words, cells_of, play_case
from end_effector_lab.virtual import VirtualTool
from tests.support.places import ROOT
from tests.unit.virtual.test_unread_outputs import until

GRIP_ERROR, GRIPPED, RELEASE_ERROR, STAND_BY = (
    EndEffectorState.GRIP_ERROR,
    EndEffectorState.GRIPPED,
    EndEffectorState.RELEASE_ERROR,
    EndEffectorState.STAND_BY,
)
LIFT = "modbus:1/0x0000"
NETWORK = {"closed-after", "cut-answers"}


@pytest.fixture(scope="module")
def tool() -> Description:
    return example("tools/remote_io")


def test_only_a_device_at_an_address_has_the_faults_of_a_network(tool: Description) -> None:
    assert {each.name for each in offered_faults(tool)} >= NETWORK
    wired = example("tools/gripper_2f85")
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


@pytest.mark.parametrize("dead", ["hal", "all"])
def test_what_died_in_a_release_says_which_one_is_owed_when_the_port_is_closed(
    tool: Description, dead: str
) -> None:
    """The releases come when the port is open again; until then no sentence may say that all outputs stay."""
    case = case_from_words(
        f"grip; wait 2; drop; wait 0.001; scenario closed-after:0; kill {dead}; wait 1; start {dead}", tool
    )
    trial = play_case(tool, case)
    assert trial.failures == {}
    told = trial.tool.statuses[trial.ended.statuses - 1]
    owed = [each for each in told.alarm_texts if "the release is repeated until it is acknowledged" in each]
    assert owed
    assert not any("stay as they are" in each for each in told.alarm_texts)


def test_a_release_that_waits_for_a_closed_port_holds_up_the_next_no_longer_than_its_time() -> None:
    tool = example("cells/three_parts")
    words = (
        "grip crate; wait 5; scenario closed-after:gripper:0; drop; wait 0.001; kill hal; wait 13; start hal"
    )
    trial = play_case(tool, case_from_words(words, tool))
    assert trial.failures == {}
    off = [each for each in trial.tool.edges if not each.level]
    lines = {each.line: name for name, each in tool.actuators.items()}
    assert [lines[each.line] for each in off][:2] == ["right", "left"]


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


BESIDE_US = "was commanded active, but its device reports otherwise: it was restarted, or another program writes to it"


def example(name: str) -> Description:
    return load_tool(ROOT / f"examples/{name}/end_effector.yaml")


def with_distant_coils(folder: Path) -> Description:
    """The lift of the I/O station on a valve with two coils that are no neighbours."""
    text = (ROOT / "examples/tools/remote_io/end_effector.yaml").read_text(encoding="utf-8")
    path = folder / "end_effector.yaml"
    path.write_text(
        text.replace("command_off: [0], verify: lift_coil", "command_off: [0], opposite: {address: 9}")
    )
    return load_tool(path)


def held(tool: Description, fault: str) -> tuple[VirtualTool, int]:
    """A tool that holds a part, three seconds after the fault; and how often its outputs had moved before."""
    played = VirtualTool(tool)
    until(played, STAND_BY)
    played.run(1.0)
    assert played.command("grip", part="crate" if tool.parts else "").accepted
    until(played, GRIPPED)
    moved = len(played.edges)
    played.choose(fault)
    played.run(3.0)
    return played, moved


def used_again(played: VirtualTool) -> None:
    played.choose("nominal")
    played.run(3.0)
    assert played.command("drop").accepted
    until(played, STAND_BY)
    assert played.reset().accepted
    assert played.command("grip").accepted
    until(played, GRIPPED)
    assert played.status.alarm_texts == ()


@pytest.mark.parametrize(
    ("name", "outputs"),
    [("tools/remote_io", 2), ("a pair of coils", 2), ("tools/gripper_2f85", 1), ("cells/three_parts", 3)],
)
def test_a_second_client_that_writes_the_outputs_is_an_alarm_where_they_are_read_back(
    tmp_path: Path, name: str, outputs: int
) -> None:
    """What it has released is released; nothing is written by this product before the Drop."""
    tool = with_distant_coils(tmp_path) if name == "a pair of coils" else example(name)
    played, moved = held(tool, "foreign-write-after:0")
    assert [each.level for each in played.edges[moved:]] == [False] * outputs, "by the other client"
    assert (played.status.ee, played.status.lift_allowed) == (GRIP_ERROR, False)
    assert sum(BESIDE_US in text for text in played.status.alarm_texts) == sum(
        bool(each.verify) for each in played.description.register_outputs.values()
    )
    used_again(played)


def test_a_second_client_that_writes_on_one_link_leaves_the_others() -> None:
    played, moved = held(example("cells/three_parts"), "foreign-write-after:gripper:0")
    assert [each.line for each in played.edges[moved:]] == [played.description.actuators["fingers"].line]


def test_another_device_at_the_address_is_no_proof_of_anything() -> None:
    """Its registers are 0: what was held counts as lost, and stays held."""
    played, moved = held(example("tools/remote_io"), "other-device-after:0")
    assert (played.status.ee, played.status.lift_allowed) == (GRIP_ERROR, False)
    assert any(BESIDE_US in text for text in played.status.alarm_texts)
    assert played.edges[moved:] == []
    assert all(played.levels.values())
    used_again(played)


def test_another_device_without_these_registers_is_named_and_what_is_held_stays_held() -> None:
    played, moved = held(example("tools/gripper_2f85"), "other-device-after:0")
    assert (played.status.ee, played.status.lift_allowed) == (GRIPPED, False)
    assert any("No valid reading of Fingers" in text for text in played.status.alarm_texts)
    assert played.edges[moved:] == []
    used_again(played)


def test_only_a_commanded_bus_has_a_second_client() -> None:
    tool = example("tools/two_epick")
    assert "foreign-write-after" not in {each.name for each in offered_faults(tool)}
    with pytest.raises(UsageError) as refused:
        parse_scenario("foreign-write-after:0", tool)
    assert "is a fault of a commanded link" in refused.value.what
