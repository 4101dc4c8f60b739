"""Whoever publishes or calls under another name has no say: nothing happens, and it is told."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from end_effector_hal.vocabulary import EndEffectorState

pytestmark = pytest.mark.ros
FORGER = Path(__file__).with_name("forger.py")
ABORTED = 4


@pytest.fixture
def forge(system: Any) -> Iterator[Any]:
    """Starts a forger, see there; it is ended after the test."""
    children = []

    def start(*arguments: str) -> Any:
        child = system.start(
            f"forger-{len(children)}-{arguments[0]}", sys.executable, str(FORGER), *arguments
        )
        children.append(child)
        child.wait_until(lambda: "forging" in child.text(), timeout_s=60.0, what="it was at work")
        return child

    yield start
    for child in children:
        child.end(signal_number=signal.SIGKILL)


@pytest.fixture(scope="module", autouse=True)
def quiet(session_system: Any) -> Iterator[None]:
    """Alarms stay for some time: they are over when the next file begins."""
    yield
    session_system.until("no alarm", lambda: not told(session_system, "are ignored"))


def told(system: Any, *words: str) -> bool:
    return any(all(word in alarm for word in words) for alarm in system.state.alarms)


def dropped(system: Any, node: str, what: str) -> int:
    """What the diagnostics of a node count."""
    import rospy
    from diagnostic_msgs.msg import DiagnosticArray

    found: list[Any] = []
    subscriber = rospy.Subscriber(
        "/diagnostics",
        DiagnosticArray,
        lambda message: found.extend(each for each in message.status if each.name == node),
    )
    system.until("diagnostics", lambda: found)
    subscriber.unregister()
    values = {each.key: each.value for each in found[-1].values}
    return int(values.get(f"dropped, {what}", 0))


@pytest.mark.parametrize("claim", ["own", "claimed"])
def test_forged_frames_confirm_nothing(system: Any, forge: Any, claim: str) -> None:
    """Every actuator confirmed, says the forger; the bottom vacuum never is."""
    system.until("no alarm of the test before", lambda: not told(system, "/sensor_frame"))
    system.world.choose("never-confirms:bottom_vacuum")
    forge("frames", claim)
    begun = len(system.states)
    status, result = system.run("TriggerGrip")
    assert status == ABORTED, result.reason
    assert "Bottom vacuum was not confirmed" in result.reason
    seen = system.states[begun:]
    assert EndEffectorState.GRIPPED not in {state.state for state in seen}
    assert all(state.actuators[0] != 2 for state in seen), "the bottom vacuum was never ON"
    who = "/forger" if claim == "own" else "another node under the name /Pressure"
    assert told(system, "/sensor_frame", who)
    assert dropped(system, "Grip", "/sensor_frame") > 0
    assert dropped(system, "Position", "/sensor_frame") > 0


def test_a_forged_status_is_no_state(system: Any, forge: Any) -> None:
    """GRIPPED, says the forger; nothing is."""
    begun = len(system.states)
    forge("status", "own")
    system.until("the alarm", lambda: told(system, "/grip/state", "/forger", "/Grip"))
    system.until("more states", lambda: len(system.states) > begun + 20)
    assert {state.state for state in system.states[begun:]} == {EndEffectorState.STAND_BY}
    assert dropped(system, "HALMain", "/grip/state") > 0
    assert dropped(system, "ToolChange", "/grip/state") > 0


def test_a_remap_leads_to_the_nodes_in_that_namespace(system: Any) -> None:
    """A node in a namespace of its own that hears the frames of the root namespace."""
    import rospy
    from end_effector_msgs.msg import CylinderPosition

    seen: list[int] = []
    subscriber = rospy.Subscriber(
        "/mirror/PositionCylinder", CylinderPosition, lambda message: seen.append(message.position)
    )
    child = system.start(
        "mirror", "rosrun", "end_effector_hal", "position", "__ns:=mirror", "sensor_frame:=/sensor_frame",
        f"_description:={system.world.description_path}",
    )  # fmt: skip
    try:
        system.until("frames", lambda: CylinderPosition.RETRACTED in seen)
    finally:
        subscriber.unregister()
        child.end()
    assert "are ignored" not in child.text()


def test_a_command_that_does_not_come_from_hal_main_is_refused(system: Any) -> None:
    edges = len(system.edges())
    done = system.cli("rosservice", "call", "/grip/command", "{command: 2, until_us: 0}")
    assert "accepted: False" in done.stdout, done.stdout + done.stderr
    system.until(
        "the alarm",
        lambda: told(system, "/grip/command", "/rosservice", "only /HALMain and /ToolChange may send there"),
    )
    assert system.edges()[edges:] == []
    assert dropped(system, "Grip", "/grip/command") == 1
    system.until("no alarm", lambda: not told(system, "/grip/command"))


def test_another_server_of_a_command_is_found_out(system: Any, forge: Any) -> None:
    """The master gives a service to whoever offered it last."""
    from end_effector_msgs.msg import Outcome

    forger = forge("server", "own")
    try:
        count, last = len(system.states), system.state.header.seq
        system.cli("rosnode", "kill", "/HALMain")  # the next one connects to the forger
        system.until("its return", lambda: any(state.header.seq < last for state in system.states[count:]))
        system.wait_for(EndEffectorState.STAND_BY)
        status, result = system.run("TriggerGrip")
        assert (status, result.outcome) == (5, Outcome.UNREACHABLE)
        assert result.reason == "Another node answers for Grip: '/forger'."
    finally:
        forger.end(signal_number=signal.SIGKILL)
        system.cli("rosnode", "kill", "/Grip")  # it offers its service again
        system.until("the grip", lambda: system.run("TriggerGrip")[0] == 3)
