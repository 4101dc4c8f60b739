"""A disk that is full while the nodes grip: the recordings of all of them fail, and nothing else does."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest

from end_effector_hal.recording import read_run
from end_effector_hal.verification.replay import load_trace, review, traces_of
from end_effector_hal.vocabulary import EndEffectorState

pytestmark = pytest.mark.ros


@pytest.fixture
def said(system: Any) -> Iterator[Callable[[str], str]]:
    """The newest diagnostics of a node."""
    import rospy
    from diagnostic_msgs.msg import DiagnosticArray

    messages: dict[str, str] = {}

    def take(message: Any) -> None:
        messages.update({status.name: status.message for status in message.status})

    subscriber = rospy.Subscriber("/diagnostics", DiagnosticArray, take)
    yield lambda name: messages.get(name, "")
    subscriber.unregister()


def lacking(system: Any) -> list[str]:
    return [alarm for alarm in system.state.alarms if "is not recorded" in alarm]


def test_a_full_disk_is_an_alarm_and_the_part_is_gripped_and_dropped(
    system: Any, said: Callable[[str], str]
) -> None:
    system.world.choose("fails-once:top_vacuum")
    goal = system.send("TriggerGrip")
    system.until("gripping", lambda: system.state.state == EndEffectorState.GRIPPING)
    system.disk.fill()
    try:
        system.until("the alarm", lambda: lacking(system))
        assert "No space left on device" in lacking(system)[0]
        status, result = goal.result()
        assert status == 3, result.reason
        system.until("diagnostics", lambda: "is not recorded" in said("Grip"))
        system.until(
            "those of the rows", lambda: "Rows of the recording cannot be written" in said("DataLogger")
        )
        status, result = system.run("Drop")
        assert status == 3, result.reason
    finally:
        system.disk.free()
    system.until("it is recorded again", lambda: not lacking(system))
    system.until("rows, too", lambda: said("DataLogger") == "As it should be.")
    system.grip()
    assert system.run("Drop")[0] == 3
    log = system.folder / "log"
    assert any("No space left on device" in gap for gap in read_run(log).gaps)
    last = traces_of(log)[-1]
    system.until("records", lambda: len(load_trace(last).file.records) > 5)
    found = review(load_trace(last))
    assert found.ok, found.as_json()
    assert found.trace.header.gap is not None
