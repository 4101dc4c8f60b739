"""A tool in a namespace beside another one; and clocks that stand still, jump ahead and back."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from end_effector_lab.demo._world import World
from tests.acceptance.contract.driver import Message
from tests.acceptance.contract.hal import GENERATION, NODES, Hal, quick
from tests.support.nightly import first_of

pytestmark = pytest.mark.ros
START_S, HOUR_S = 1_000_000.0, 3600.0


@pytest.fixture(scope="module")
def left(running: Hal, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Hal]:
    """A second tool with hardware of its own, in the namespace ``/left``, a frame of its own, and a simulated clock."""
    running.start_all()
    folder = tmp_path_factory.mktemp("left")
    running.driver.ask("clock", seconds=START_S)
    with World(quick(), "nominal", folder) as world:
        own = {"frame_id": "left_flange", **({"use_sim_time": "true"} if GENERATION == 2 else {})}
        hal = Hal(world, running.ros, running.layout, running.driver, "/left", own)
        if GENERATION == 1:
            running.driver.ask("set_parameter", node="", name="use_sim_time", value=True)
        try:
            hal.start_all()
            hal.connect()
        finally:
            if GENERATION == 1:
                running.driver.ask("set_parameter", node="", name="use_sim_time", value=False)
        yield hal
        hal.end_all()


@pytest.fixture
def both(resting: Hal, left: Hal) -> tuple[Hal, Hal]:
    left.driver.ask("clock", seconds=START_S)
    left.rest()
    return resting, left


def test_every_name_moves_into_the_namespace(both: tuple[Hal, Hal]) -> None:
    root, _ = both

    def names(space: str) -> set[tuple[str, str]]:
        own = {f"{space}/{node}" for node in NODES}
        return {(each["is"], each["name"]) for each in root.driver.graph() if each["node"] in own}

    wanted = {
        (what, name if name.startswith(("/diagnostics", "/clock")) else f"/left{name}")
        for what, name in names("")
    }
    root.until("the same names", lambda: names("/left") - {("subscriber", "/clock")} == wanted)
    assert {f"/left/{node}" for node in NODES} <= set(root.driver.ask("nodes"))


def test_pressures_have_the_frame_of_their_tool_or_the_one_that_is_named(both: tuple[Hal, Hal]) -> None:
    """Where it is measured, as a transform knows it: never the name of a channel."""
    heard = [hal.driver.subscribe(hal.full("PressureVacuumTop"), "sensor_msgs/FluidPressure") for hal in both]
    both[0].until("both", lambda: all(each.messages for each in heard))
    frames = [each.newest["header"]["frame_id"] for each in heard]
    assert frames == ["verdin_gripper_link", "left_flange"]


def test_one_tool_grips_and_the_other_does_not_move(both: tuple[Hal, Hal]) -> None:
    root, left = both
    begun, edges = root.since, root.edges()
    left.do("TriggerGrip")
    left.wait_for("GRIPPED")
    assert {each["state_name"] for each in root.after(begun)} == {"STAND_BY"}
    assert root.edges() == edges
    assert root.refused("Drop").startswith("Nothing is held"), "its own state counts"


@pytest.mark.nightly
def test_both_tools_hold_and_each_drops_its_own(both: tuple[Hal, Hal]) -> None:
    root, left = both
    goals = [hal.send("TriggerGrip") for hal in both]
    assert {goal.end()[1]["outcome_name"] for goal in goals} == {"SUCCEEDED"}
    root.do("Drop")
    assert left.wait_for("GRIPPED")["held"]
    left.do("Drop")


def stamps(messages: list[Message]) -> list[float]:
    return [message["header"]["stamp"] / 1e9 for message in messages]


def test_stamps_are_those_of_a_simulated_clock(both: tuple[Hal, Hal]) -> None:
    _, left = both
    left.driver.ask("clock", seconds=START_S + 5)
    left.sees("its stamp", lambda state: stamps([state]) == [START_S + 5])


@pytest.mark.parametrize("jump_s", first_of([-HOUR_S, HOUR_S], thinned=0), ids=["back", "ahead"])
def test_a_grip_goes_on_through_a_jump_of_time(both: tuple[Hal, Hal], jump_s: float) -> None:
    """Waits, time-outs and the 10 Hz are measured with the monotonic clock."""
    _, left = both
    begun = left.since
    goal = left.begin_goal("TriggerGrip", "GRIPPING", lambda state: state["state_name"] == "GRIPPING")
    left.driver.ask("clock", seconds=START_S + jump_s)
    result = goal.end()[1]
    assert (result["outcome_name"], result["reason"]) == ("SUCCEEDED", "")
    assert 0.1 < result["seconds"] < 30
    left.sees("its stamp", lambda state: stamps([state]) == [START_S + jump_s])
    assert len({each["since_us"] for each in left.after(begun)}) == 1


def test_what_is_held_stays_held_while_the_clock_jumps(both: tuple[Hal, Hal]) -> None:
    _, left = both
    left.hold()
    edges, begun = left.edges(), left.since
    for seconds in (START_S + HOUR_S, START_S - HOUR_S, 1.0, START_S):
        left.driver.ask("clock", seconds=seconds)
        left.sees("its stamp", lambda state, seconds=seconds: stamps([state]) == [seconds])
    assert {(each["held"], each["lift_allowed"]) for each in left.after(begun)} == {(True, True)}
    assert left.edges() == edges
    left.do("Drop")
