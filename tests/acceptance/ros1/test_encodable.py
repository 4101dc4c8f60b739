"""A text that nobody can encode ends no node: the message goes out with that text repaired."""

from __future__ import annotations

import io
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from end_effector_hal.arbiter.records._record_file import RecordFile
from end_effector_hal.arbiter.records._storage import FileStorage
from end_effector_hal.control import StepReport
from end_effector_hal.description import load, profile_path
from end_effector_hal.vocabulary import Alarm, EndEffectorState
from end_effector_lab.demo._world import World
from tests.support.lone_node import status
from tests.support.patience import PATIENCE_S

pytestmark = pytest.mark.ros
RECORDED = rb'{"boot":"","clean":false,"faults":{"x\ud800":"IL-04: \ud800 both\nbits."}}'
"""A journal whose text cannot be encoded."""


def test_a_message_that_cannot_be_encoded_is_sent_repaired(monkeypatch: pytest.MonkeyPatch) -> None:
    import rospy

    from end_effector_hal.nodes._hal_main import Aggregate
    from end_effector_hal.nodes.interface import END_EFFECTOR_STATE
    from end_effector_hal.ros1._messages import TopicPublisher

    sent: list[Any] = []

    class Publisher:
        def __init__(self, *_: object, **__: object) -> None:
            """As rospy's, which writes a message down when it is published."""

        def publish(self, message: Any) -> None:
            message.serialize(io.BytesIO())
            sent.append(message)

    monkeypatch.setattr(rospy, "Publisher", Publisher)
    monkeypatch.setattr(rospy.rostime, "_rostime_initialized", True)
    aggregate = Aggregate(load(profile_path()), 0)
    alarms = tuple(
        Alarm("link.fault", str(number), {"text": text}) for number, text in enumerate(("µ", "\udfff"))
    )
    wrong = status(reason="a\ud800b", alarms=alarms, steps=(StepReport("\ud800", 1, 0.5, confirmed=True),))
    publish = TopicPublisher(END_EFFECTOR_STATE, lambda: False)
    message = aggregate.message(wrong, {}, 0, count=1, stamp_us=None)
    publish(message)
    (repaired,) = sent
    assert (repaired.reason, repaired.alarms, repaired.steps[0].actuator) == ("a?b", ["µ", "?"], "?")
    assert message.reason == "a\ud800b", "the message itself is left as it is"
    publish(aggregate.message(status(reason="as it is\n"), {}, 0, count=1, stamp_us=None))
    assert sent[1].reason == "as it is\n"


@pytest.fixture
def started(system: Any, tmp_path: Path) -> Iterator[World]:
    """A tool whose line arbiter starts with that journal."""
    world = World(load(profile_path()), "nominal", tmp_path)
    journal = world.socket.with_name(f"{world.socket.name}.journal")
    RecordFile(FileStorage(journal, durable=True)).keep(RECORDED)
    with world:
        launch = system.launch(world, name="started", env={"ROS_NAMESPACE": "/started"})
        try:
            yield world
        finally:
            launch.end(signal_number=signal.SIGINT, patience_s=20.0)


def test_the_hal_starts_on_a_journal_that_holds_such_a_text(system: Any, started: World) -> None:
    import rospy
    from end_effector_msgs.msg import EndEffectorState as Message
    from std_srvs.srv import Trigger

    states: list[Any] = []
    subscriber = rospy.Subscriber("/started/EndEffectorState", Message, states.append)
    try:
        system.until(
            "STAND_BY with the fault shown",
            lambda: (
                states
                and states[-1].state == EndEffectorState.STAND_BY
                and "IL-04: ? both bits." in states[-1].alarms
            ),
        )
        rospy.wait_for_service("/started/ResetFaults", PATIENCE_S)
        assert rospy.ServiceProxy("/started/ResetFaults", Trigger)().success
        system.until("no alarm", lambda: not states[-1].alarms)
    finally:
        subscriber.unregister()
