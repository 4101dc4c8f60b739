"""Nodes on a tool that ``eehal serve`` runs (``connect``): ROS comes and goes, and the tool does not notice it.

HALMain and the HAL are two processes here: what HALMain says of a HAL that hangs, dies and is back.
"""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator

import pytest

from end_effector_lab.demo._world import World
from end_effector_lab.processes import EEHAL
from tests.acceptance.contract.differences import Difference
from tests.acceptance.contract.hal import NODES, Hal, is_hold, quick
from tests.support.stopped import stop

pytestmark = pytest.mark.ros
SERVE = "serve"


def serve(hal: Hal) -> None:
    """Start the HAL of its tool."""
    hal.children[SERVE] = hal.world.children.start(
        SERVE,
        [*EEHAL, "serve", str(hal.world.description_path)],
        log=hal.world.folder / f"serve-{time.monotonic_ns()}.log",
        end_by=signal.SIGINT,
        patience_s=20.0,
    )


def pid_of_the_hal(hal: Hal) -> int:
    return hal.children[SERVE].pid


@pytest.fixture(scope="module")
def attached(running: Hal, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Hal]:
    """A second tool, which ``eehal serve`` runs, with its nodes in the namespace ``/served``."""
    running.start_all()
    with World(quick(), "nominal", tmp_path_factory.mktemp("served")) as world:
        hal = Hal(world, running.ros, running.layout, running.driver, "/served", {"connect": "true"})
        serve(hal)
        hal.start_all()
        hal.connect()
        yield hal
        hal.end_all()


@pytest.fixture
def served(attached: Hal) -> Hal:
    """With a part that is held, and everything running."""
    if attached.children[SERVE].code is not None:
        serve(attached)
    attached.start_all()
    attached.hold()
    return attached


def decides_again(hal: Hal) -> None:
    """It comes to what is asked of it now, after all that was asked before; at first too late, or it is still lost."""
    hal.wait_for("GRIPPED")
    why = "A grip is accepted in STAND_BY only; the end-effector is GRIPPED."
    hal.until("an answer", lambda: hal.send("TriggerGrip").end()[1]["reason"] == why)
    assert hal.refused("TriggerGrip") == why


def test_all_of_ros_is_killed_and_back_and_the_tool_does_not_notice(served: Hal) -> None:
    edges, pid = served.edges(), pid_of_the_hal(served)
    for node in NODES[:1] if served.one else NODES:
        served.kill(node)
    begun = served.since
    served.start_all()
    served.serve()
    served.until("GRIPPED", lambda: any(map(is_hold, served.after(begun))))
    assert {each["held"] for each in served.after(begun) if each["state_name"] != "OFF"} == {True}
    assert (served.edges(), pid_of_the_hal(served)) == (edges, pid)
    assert served.children[SERVE].code is None


def test_a_grip_goes_on_when_hal_main_ends(served: Hal) -> None:
    served.do("Drop")
    served.rest()
    served.choose("never-confirms:top_vacuum")
    goal = served.begin_goal("TriggerGrip", "the last step", lambda state: state["outputs"] == [True] * 3)
    served.signal("HALMain", signal.SIGTERM)
    _, result = goal.end()
    assert result["outcome_name"] == "UNREACHABLE"
    assert "GRIP continues: the HAL executes it. See EndEffectorState" in result["reason"]
    served.until("its end", lambda: served.children[served.program("HALMain")].code == 0)
    served.choose("nominal")
    begun = served.since
    served.start_all()
    served.serve()
    served.until("GRIPPED", lambda: any(map(is_hold, served.after(begun))))


def test_a_hal_that_dies_is_an_alarm_until_it_is_back(served: Hal) -> None:
    edges = served.edges()
    os.kill(pid_of_the_hal(served), signal.SIGKILL)
    served.sees("OFF", lambda state: state["state_name"] == "OFF")
    served.until("an alarm", lambda: "hal.lost" in served.state["alarm_ids"])
    assert (served.state["held"], served.state["lift_allowed"]) == (True, False)
    assert (served.state["tool_changer_name"], served.state["link_up"]) == ("UNKNOWN", False)
    served.until("its end", lambda: served.children[SERVE].code is not None)
    serve(served)
    served.sees("GRIPPED", lambda state: state["state_name"] == "GRIPPED" and state["lift_allowed"])
    served.until("no alarm", lambda: "hal.lost" not in served.state["alarm_ids"])
    assert served.edges() == edges


def test_a_command_to_a_hal_that_hangs_is_never_executed(served: Hal) -> None:
    """The client was told that the drop was given up: it must not happen when the HAL goes on."""
    edges = served.edges()
    stop(pid_of_the_hal(served))
    try:
        served.sees("OFF", lambda state: state["state_name"] == "OFF")
        assert served.alarmed("The HAL is silent")
        assert (served.state["held"], served.state["lift_allowed"]) == (True, False)
        # those that pile up are in nobody's way either
        drops = [served.send("Drop") for _ in range(3)]
        ends = [drop.end() for drop in drops]
    finally:
        os.kill(pid_of_the_hal(served), signal.SIGCONT)
    status = served.by(Difference.REFUSED_GOAL, ros1="REJECTED", ros2="ABORTED")
    assert {(each, result["outcome_name"]) for each, result in ends} == {(status, "UNREACHABLE")}
    assert all(result["reason"].startswith("The HAL does not answer") for _, result in ends)
    decides_again(served)
    assert served.edges() == edges


@pytest.mark.nightly
def test_more_goals_than_are_kept_are_refused_in_words(served: Hal) -> None:
    stop(pid_of_the_hal(served))
    try:
        drops = [served.send("Drop") for _ in range(12)]
        refused = "10 goals of Drop wait for their answer: no more are accepted. Wait for their end."
        reasons = [drop.end()[1]["reason"] for drop in drops]
    finally:
        os.kill(pid_of_the_hal(served), signal.SIGCONT)
    assert reasons.count(refused) == 2
    assert len([reason for reason in reasons if reason.startswith("The HAL does not answer")]) == 10
    decides_again(served)
