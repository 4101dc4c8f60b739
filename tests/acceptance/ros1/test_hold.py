"""A held part, watched: what goes wrong is in the diagnostics and in the recording, and the Supervisor resets it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest

from end_effector_hal.recording import read_alarms
from end_effector_hal.vocabulary import EndEffectorState

pytestmark = pytest.mark.ros
WARN = 1


@pytest.fixture
def diagnostics(system: Any) -> Iterator[Callable[[], Any]]:
    """The newest of HALMain."""
    import rospy
    from diagnostic_msgs.msg import DiagnosticArray

    newest: list[Any] = []

    def take(message: Any) -> None:
        newest.extend(status for status in message.status if status.name == "HALMain")

    subscriber = rospy.Subscriber("/diagnostics", DiagnosticArray, take)
    yield lambda: newest[-1] if newest else None
    subscriber.unregister()


def told(system: Any, words: str) -> bool:
    return any(words in alarm for alarm in system.state.alarms)


def test_a_weak_grip_is_told_until_it_is_over_and_reset(system: Any, diagnostics: Callable[[], Any]) -> None:
    system.world.choose("leak:top_vacuum")
    system.grip()
    system.until("the alarm", lambda: told(system, "Weak grip: Top vacuum"))
    state = system.state
    assert (state.state, state.lift_allowed, state.secure) == (EndEffectorState.GRIPPED, True, False)
    system.until("a warning", lambda: (found := diagnostics()) and "Weak grip" in found.message)
    assert diagnostics().level == WARN
    system.world.choose("nominal")
    system.until("secure", lambda: system.state.secure)
    system.until("what is over", lambda: told(system, "Over: Top vacuum"))
    done = system.cli("rosrun", "end_effector_hal", "supervisor", "__name:=resetter", "_script:=reset; quit")
    assert (done.returncode, "reset: SUCCEEDED" in done.stdout) == (0, True), done.stdout + done.stderr
    system.until("no alarm", lambda: not told(system, "Top vacuum"))
    assert system.state.state == EndEffectorState.GRIPPED
    assert system.run("Drop")[0] == 3
    written = system.folder / "log" / "alarms.csv"
    system.until(
        "the recording", lambda: any("Weak grip: Top vacuum" in row.text for row in read_alarms(written))
    )
