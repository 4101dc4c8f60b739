"""What the HAL tells of its tool: the state, its times; pressures, positions, joints; who comes late."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping

import pytest

from tests.acceptance.contract.driver import Driver, Heard, Message
from tests.acceptance.contract.hal import STROKE_MM, Hal

pytestmark = pytest.mark.ros
STATE = "end_effector_msgs/EndEffectorState"
PRESSURE, CYLINDER = "sensor_msgs/FluidPressure", "end_effector_msgs/CylinderPosition"
JOINT, CYLINDER_JOINT = "verdin_gripper_joint", "verdin_gripper_cylinder_joint"


@pytest.fixture(scope="module")
def heard(running: Hal) -> Iterator[Mapping[str, Heard]]:
    """Topics beside the state."""
    kinds = {
        "PressureSupply": PRESSURE, "PressureCylinder": PRESSURE,
        "PressureVacuumBottom": PRESSURE, "PressureVacuumTop": PRESSURE,
        "PositionCylinder": CYLINDER, "PositionToolStand": "end_effector_msgs/ToolStandPosition",
        "joint_states": "sensor_msgs/JointState", "/diagnostics": "diagnostic_msgs/DiagnosticArray",
    }  # fmt: skip
    found = {name: running.driver.subscribe(running.full(name), kind) for name, kind in kinds.items()}
    running.until("all", lambda: all(each.messages for each in found.values()))
    yield found
    running.driver.leave(*found.values())


def test_at_rest(resting: Hal) -> None:
    state = resting.state
    assert (state["tool"], state["state"], state["state_name"]) == ("verdin_gripper", 6, "STAND_BY")
    assert (state["command"], state["command_name"]) == (-1, "NONE")
    assert state["actuator_names"] == ["bottom_vacuum", "cylinder", "top_vacuum"]
    assert state["actuator_kinds"] == ["vacuum", "cylinder", "vacuum"]
    assert (state["actuators"], state["actuator_states"]) == ([0, 0, 0], ["OFF", "RETRACTED", "OFF"])
    assert (state["outputs"], state["evidence"]) == ([False] * 3, [1] * 3)
    assert (state["held"], state["lift_allowed"], state["secure"], state["maintenance"]) == (False,) * 4
    assert (state["tool_changer"], state["tool_changer_name"], state["unlock_output"]) == (1, "LOCKED", False)
    assert (state["tool_position_name"], state["tool_stand_name"]) == ("LOCKED", "IN_STAND")
    assert (state["link_up"], state["stale"], state["margin_units"]) == (True, [], ["Pa"] * 3)
    assert math.isnan(state["time_left_s"])
    assert state["positions"][1] == 0.0


def test_while_gripped(holding: Hal) -> None:
    state = holding.state
    assert (state["state"], state["state_name"], state["command_name"]) == (3, "GRIPPED", "NONE")
    assert (state["actuators"], state["actuator_states"]) == ([2, 2, 2], ["ON", "EXTENDED", "ON"])
    assert (state["outputs"], state["evidence_names"]) == ([True] * 3, ["CONFIRMED"] * 3)
    assert (state["held"], state["lift_allowed"]) == (True, True)
    assert [str(each) for each in state["positions"]] == ["nan", str(STROKE_MM / 1000), "nan"]
    assert all(margin > 0 for margin in state["margins"])


def test_a_late_joiner_first_sees_that_a_part_is_held(resting: Hal, client: Callable[[], Driver]) -> None:
    late = client()
    late.ask("nodes")
    resting.do("TriggerGrip")
    gripped = resting.sees("GRIPPED", lambda state: state["state_name"] == "GRIPPED")
    states = late.subscribe(resting.full("EndEffectorState"), STATE, latched=True)
    resting.until("a state", lambda: states.messages)
    assert (states.messages[0]["held"], states.messages[0]["state_name"]) == (True, "GRIPPED")
    assert states.messages[0]["count"] >= gripped["count"]


@pytest.mark.nightly
def test_a_late_joiner_sees_no_old_held(holding: Hal, client: Callable[[], Driver]) -> None:
    """A queue of earlier messages would say for a while that the part which was dropped is held."""
    late = client()
    late.ask("nodes")
    holding.do("Drop")
    holding.sees("nothing held", lambda state: not state["held"])
    states = late.subscribe(holding.full("EndEffectorState"), STATE, latched=True)
    places = late.subscribe(holding.full("PositionCylinder"), CYLINDER, latched=True)
    holding.until("states and positions", lambda: len(states.messages) > 2 and len(places.messages) > 2)
    assert {(each["held"], each["state_name"]) for each in states.messages} == {(False, "STAND_BY")}
    assert {each["position_name"] for each in places.messages} == {"RETRACTED"}


def test_the_count_tells_changes_apart_from_repetitions(resting: Hal) -> None:
    begun = resting.since
    resting.do("TriggerGrip")
    resting.wait_for("GRIPPED")
    resting.until("repetitions", lambda: len({each["count"] for each in resting.states.messages[-3:]}) == 1)
    messages = resting.after(begun)
    counts = [each["count"] for each in messages]
    assert counts == sorted(counts)
    assert set(counts) == set(range(counts[0], counts[-1] + 1)), "no change is missed"
    shown = {(each["count"], each["state"], tuple(each["actuators"])) for each in messages}
    assert len(shown) == len(set(counts))
    assert len({each["since_us"] for each in messages}) == 1


def test_a_change_carries_its_time_and_a_repetition_that_of_the_last_change(resting: Hal) -> None:
    begun = resting.since
    resting.do("TriggerGrip")
    resting.until("a repetition", lambda: resting.state["at_us"] == resting.states.messages[-3]["at_us"])
    messages = resting.after(begun)
    times = {each["count"]: each["at_us"] for each in messages}
    assert len(set(times.values())) >= 7
    assert all(each["at_us"] == times[each["count"]] for each in messages)
    steps = {
        each["at_us"]: each["header"]["stamp"] / 1000 for each in messages if each["command_name"] == "GRIP"
    }
    (first, begun_us), (last, ended_us) = min(steps.items()), max(steps.items())
    assert ended_us - begun_us == pytest.approx(last - first, abs=500_000)


@pytest.mark.parametrize(
    "names", [("PressureVacuumBottom", "PressureCylinder"), ("PositionCylinder", "PositionToolStand")]
)
def test_what_one_frame_brought_has_one_stamp(
    resting: Hal, heard: Mapping[str, Heard], names: tuple[str, str]
) -> None:
    """The exact synchronizer of message_filters finds what belongs together by equal stamps."""

    def common() -> set[int]:
        one, other = ({each["header"]["stamp"] for each in heard[name].messages} for name in names)
        return one & other

    before = len(common())
    resting.until("equal stamps", lambda: len(common()) >= before + 5, 10.0)


def test_pressures_are_absolute_pascal(resting: Hal, heard: Mapping[str, Heard]) -> None:
    newest = {name: heard[name].newest["fluid_pressure"] for name in heard if name.startswith("Pressure")}
    assert newest["PressureSupply"] == pytest.approx(101_325 + 600_000, abs=3_000)
    assert newest["PressureVacuumBottom"] == pytest.approx(101_325, abs=1_000)


def test_vacuum_is_below_the_pressure_of_the_air(holding: Hal, heard: Mapping[str, Heard]) -> None:
    assert 0 < heard["PressureVacuumBottom"].newest["fluid_pressure"] < 101_325 - 55_000
    assert heard["PressureCylinder"].newest["fluid_pressure"] > 101_325 + 400_000


def test_a_lost_reading_is_nowhere_the_last_value(resting: Hal, heard: Mapping[str, Heard]) -> None:
    pressures, health = heard["PressureVacuumTop"], heard["/diagnostics"]

    def told(words: str) -> bool:
        return any(words in each["message"] for message in health.messages for each in message["status"])

    resting.choose("shows:top_vacuum:300")
    resting.until("an impossible value is none", lambda: math.isnan(pressures.newest["fluid_pressure"]))
    resting.until("which and why", lambda: told("channel top shows"))
    resting.until("an alarm", lambda: resting.alarmed("channel top shows"))
    resting.choose("silent-after:0")
    resting.until("silence is said", lambda: told("no frame comes"))
    state = resting.sees("nothing is known", lambda each: each["evidence_names"] == ["UNKNOWN"] * 3)
    assert all(map(math.isnan, state["margins"]))


@pytest.mark.parametrize(("bench", "place"), [("not-in-stand", "AWAY"), ("no-tool", "ABSENT")])
def test_the_place_of_the_tool_is_that_of_its_sensors(
    resting: Hal, heard: Mapping[str, Heard], bench: str, place: str
) -> None:
    resting.choose(bench)
    resting.sees(place, lambda state: state["tool_stand_name"] == place)
    resting.until("its topic", lambda: heard["PositionToolStand"].newest["position_name"] == place)


def joints(message: Message) -> dict[str, float]:
    return dict(zip(message["name"], message["position"], strict=True))


def test_the_cylinder_and_the_joints_move_by_their_sensors_alone(
    resting: Hal, heard: Mapping[str, Heard]
) -> None:
    """A joint is left out while nobody can prove where it stands."""
    released, gripped = {CYLINDER_JOINT: 0.0, JOINT: 1.0}, {CYLINDER_JOINT: STROKE_MM / 1000, JOINT: 0.0}
    said, places = heard["joint_states"], heard["PositionCylinder"]
    resting.until("released", lambda: joints(said.newest) == released)
    begun, first = len(said.messages), len(places.messages)
    resting.do("TriggerGrip")
    resting.until("gripped", lambda: joints(said.newest) == gripped)
    way = [joints(each) for each in said.messages[begun - 1 :]]
    changes = [each for at, each in enumerate(way) if at and each != way[at - 1]]
    assert changes == [{CYLINDER_JOINT: 0.0}, {CYLINDER_JOINT: STROKE_MM / 1000}, gripped]
    resting.until("extended", lambda: places.newest["position_name"] == "EXTENDED")
    names = list(dict.fromkeys(each["position_name"] for each in places.messages[first - 1 :]))
    assert names == ["RETRACTED", "BETWEEN", "EXTENDED"]
    assert (places.messages[first - 1]["fraction"], places.newest["fraction"]) == (0.0, 1.0)


@pytest.mark.nightly
def test_a_weak_grip_is_told_until_it_is_over_and_reset(resting: Hal, heard: Mapping[str, Heard]) -> None:
    health = heard["/diagnostics"]
    resting.choose("leak:top_vacuum")
    resting.do("TriggerGrip")
    resting.until("the alarm", lambda: resting.alarmed("Weak grip: Top vacuum"))
    state = resting.state
    assert (state["state_name"], state["lift_allowed"], state["secure"]) == ("GRIPPED", True, False)
    resting.until(
        "a warning", lambda: any("Weak grip" in each["message"] for each in health.newest["status"])
    )
    resting.choose("nominal")
    resting.until("what is over", lambda: resting.state["secure"] and resting.alarmed("Over: Top vacuum"))
    assert resting.call("ResetFaults")[0]
    resting.until("no alarm", lambda: not resting.alarmed("Top vacuum"))
    assert resting.state["state_name"] == "GRIPPED"


def test_a_lost_grip_is_an_error_that_only_a_drop_ends(holding: Hal) -> None:
    edges = holding.edges()
    holding.choose("lost-after:bottom_vacuum:0.1")
    state = holding.wait_for("GRIP_ERROR")
    assert (state["held"], state["lift_allowed"], state["cause_actuator"]) == (True, False, "bottom_vacuum")
    assert state["reason"].startswith("Bottom vacuum was lost: ")
    holding.until("what to do", lambda: holding.alarmed("only a Drop releases"))
    assert holding.edges() == edges, "a loss moves no line"
    assert "GRIP_ERROR" in holding.refused("TriggerGrip")
    holding.do("Drop")
    assert [line for line, level in holding.edges()[len(edges) :] if not level] == [
        "SODIMM_212", "SODIMM_210", "SODIMM_208",
    ]  # fmt: skip


def test_silence_while_held_freezes_and_is_told(holding: Hal) -> None:
    edges = holding.edges()
    holding.choose("silent-after:0")
    state = holding.sees("UNKNOWN", lambda each: each["evidence_names"] == ["UNKNOWN"] * 3)
    assert (state["state_name"], state["held"], state["lift_allowed"]) == ("GRIPPED", True, False)
    holding.until("the alarm", lambda: holding.alarmed("No valid reading of Bottom vacuum while"))
    holding.sees(
        "no positions", lambda each: (each["tool_position_name"], each["tool_stand_name"]) == ("UNKNOWN",) * 2
    )
    holding.choose("nominal")
    holding.sees("a fresh reading", lambda each: each["lift_allowed"])
    assert holding.edges() == edges
