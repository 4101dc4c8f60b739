"""EndEffectorState: latched, at 10 Hz, in the integers of Table II."""

from __future__ import annotations

import math
import time
from typing import Any

import pytest

from end_effector_hal.kinds.cylinder import CylinderState
from end_effector_hal.kinds.vacuum import VacuumState
from end_effector_hal.vocabulary import Command, EndEffectorState
from tests.support.patience import PATIENCE_S

pytestmark = pytest.mark.ros


def test_it_is_latched(system: Any) -> None:
    assert system.state._connection_header["latching"] == "1"


def test_it_comes_at_10_hz_while_nothing_changes(system: Any) -> None:
    before = len(system.states)
    system.until("21 messages", lambda: len(system.states) >= before + 21)
    stamps = [message.header.stamp.to_sec() for message in system.states[before : before + 21]]
    assert 1.6 < stamps[-1] - stamps[0] < 10.0  # a busy machine leaves ticks out, it adds none


@pytest.mark.parametrize(
    "topics", [("PressureVacuumBottom", "PressureCylinder"), ("PositionCylinder", "PositionToolStand")]
)
def test_what_one_frame_brought_has_one_stamp(system: Any, topics: tuple[str, str]) -> None:
    """The exact synchronizer of message_filters finds what belongs together by equal stamps."""
    import rospy

    heard: list[list[bytes]] = [[], []]
    subscribers = [
        rospy.Subscriber(
            topic,
            rospy.AnyMsg,
            # a header begins with its number, seconds and nanoseconds
            lambda message, stamps=stamps: stamps.append(message._buff[4:12]),
        )
        for topic, stamps in zip(topics, heard, strict=True)
    ]
    try:
        system.until("equal stamps", lambda: len(set(heard[0]) & set(heard[1])) >= 5)
    finally:
        for subscriber in subscribers:
            subscriber.unregister()


def test_its_constants_are_those_of_table_ii() -> None:
    from end_effector_msgs.msg import Command as CommandMsg
    from end_effector_msgs.msg import CylinderState as CylinderMsg
    from end_effector_msgs.msg import State
    from end_effector_msgs.msg import VacuumState as VacuumMsg

    for table, message in (
        (EndEffectorState, State), (Command, CommandMsg), (VacuumState, VacuumMsg), (CylinderState, CylinderMsg),
    ):  # fmt: skip
        constants = {
            name: value for name, value in vars(message).items() if name.isupper() and isinstance(value, int)
        }
        assert constants == {state.name: state.value for state in table}


def test_at_rest(system: Any) -> None:
    state = system.state
    assert (state.state, state.command, list(state.actuators)) == (6, -1, [0, 0, 0])
    assert list(state.actuator_names) == ["bottom_vacuum", "cylinder", "top_vacuum"]
    assert list(state.outputs) == [False] * 3
    assert list(state.evidence) == [1, 1, 1]
    assert not state.lift_allowed
    assert not state.held
    assert state.link_up
    assert state.tool_changer == 1
    assert math.isnan(state.time_left_s)


def test_pressures_are_absolute_pascal(system: Any) -> None:
    import rospy
    from sensor_msgs.msg import FluidPressure

    message = rospy.wait_for_message("PressureSupply", FluidPressure, timeout=PATIENCE_S)
    assert message.fluid_pressure == pytest.approx(101_325 + 600_000, abs=3_000)
    message = rospy.wait_for_message("PressureVacuumBottom", FluidPressure, timeout=PATIENCE_S)
    assert message.fluid_pressure == pytest.approx(101_325, abs=1_000)


def test_a_lost_reading_is_nowhere_the_last_value(system: Any) -> None:
    import rospy
    from diagnostic_msgs.msg import DiagnosticArray
    from sensor_msgs.msg import FluidPressure

    pressures: list[float] = []
    said: list[str] = []

    def listen(message: Any) -> None:
        said.extend(status.message for status in message.status if status.name.endswith("Pressure"))

    subscribers = [
        rospy.Subscriber(
            "PressureVacuumTop", FluidPressure, lambda msg: pressures.append(msg.fluid_pressure)
        ),
        rospy.Subscriber("/diagnostics", DiagnosticArray, listen),
    ]
    try:
        system.until("a pressure", lambda: pressures and not math.isnan(pressures[-1]))
        system.world.choose("shows:top_vacuum:300")
        system.until("an impossible value is none", lambda: math.isnan(pressures[-1]))
        system.until("which and why", lambda: any("channel top shows" in text for text in said))
        assert any("channel top shows" in alarm for alarm in system.state.alarms)
        system.world.choose("nominal")
        system.until("a pressure again", lambda: not math.isnan(pressures[-1]))
        system.world.choose("silent-after:0")
        system.until("silence is no value", lambda: math.isnan(pressures[-1]))
        system.until("silence is said", lambda: any("no frame comes" in text for text in said))
        state = system.state
        assert (list(state.evidence), all(map(math.isnan, state.margins))) == ([0, 0, 0], True)
    finally:
        for subscriber in subscribers:
            subscriber.unregister()


def test_diagnostics_come_from_every_node_once_a_second(system: Any) -> None:
    import rospy
    from diagnostic_msgs.msg import DiagnosticArray

    seen: dict[str, list[float]] = {}
    subscriber = rospy.Subscriber(
        "/diagnostics",
        DiagnosticArray,
        lambda message: seen.setdefault(message._connection_header["callerid"], []).append(time.monotonic()),
    )
    try:
        system.until(
            "three of each",
            lambda: len(seen) >= 6 and all(len(times) >= 3 for times in seen.values()),
        )
    finally:
        subscriber.unregister()
    assert set(seen) == {"/HALMain", "/Grip", "/ToolChange", "/Pressure", "/Position", "/DataLogger"}
    for times in seen.values():
        assert times[2] - times[0] == pytest.approx(2.0, abs=1.5)


def test_a_change_carries_its_time_and_a_repetition_that_of_the_last_change(system: Any) -> None:
    begun = len(system.states)
    system.grip()
    system.until("a repetition", lambda: system.states[-1].at_us == system.states[-3].at_us)
    messages = system.states[begun:]
    # of what one unit says: two units speak over two connections
    shown = [(message.state, list(message.actuators)) for message in messages]
    changes = [at for at in range(1, len(messages)) if shown[at] != shown[at - 1]]
    times = [messages[at].at_us for at in changes]
    assert len(times) >= 7
    assert times == sorted(times)
    steps = {
        message.at_us: message.header.stamp.to_nsec() / 1000 for message in messages if message.command == 2
    }
    (first, begun_us), (last, ended_us) = min(steps.items()), max(steps.items())
    assert ended_us - begun_us == pytest.approx(last - first, abs=500_000)
