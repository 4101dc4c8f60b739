"""A sensor fault of the tool changer (IL-04): latched, refused by a reset while it lasts, cleared once it is over."""

from __future__ import annotations

from typing import Any

import pytest

pytestmark = pytest.mark.ros
SUCCEEDED, REJECTED = 3, 5
LOCKED, FAULT = 1, 5
BOTH = "IL-04: locked and unlocked were both on, or both off, for 0.5 s: a sensor fault, until a reset."


def reset() -> tuple[bool, str]:
    import rospy
    from std_srvs.srv import Trigger

    answer = rospy.ServiceProxy("ResetFaults", Trigger)()
    return answer.success, answer.message


@pytest.mark.parametrize("lie", ["unlocked-shows:tool_changer:1", "locked-shows:tool_changer:0"])
def test_a_sensor_fault_is_latched_until_a_reset_with_right_sensors(system: Any, lie: str) -> None:
    edges = system.edges()
    system.world.choose(lie)
    system.until("FAULT", lambda: system.state.tool_changer == FAULT)
    system.until("the alarm", lambda: BOTH in system.state.alarms)
    assert reset() == (False, f"The sensors of the tool changer still contradict each other. {BOTH}")
    assert system.state.tool_changer == FAULT
    for action in ("UnlockToolChanger", "TriggerGrip"):
        status, result = system.run(action)
        assert status == REJECTED, (action, result.reason)

    system.world.choose("nominal")
    system.until("right sensors", lambda: system.state.tool_position == LOCKED)
    status, result = system.run("UnlockToolChanger")
    assert (status, result.reason) == (REJECTED, f"The tool changer is FAULT. {BOTH}"), "it is latched"
    system.until("a reset", lambda: reset()[0])
    system.until("LOCKED", lambda: system.state.tool_changer == LOCKED)
    system.until("no alarm", lambda: BOTH not in system.state.alarms)
    assert system.edges() == edges, "no line has moved"
    system.grip()
