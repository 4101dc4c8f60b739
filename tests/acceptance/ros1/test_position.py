"""Positions are published by the sensors alone, and stand in the state."""

from __future__ import annotations

from typing import Any

import pytest

pytestmark = pytest.mark.ros
UNKNOWN, IN_STAND, AWAY, ABSENT = range(4)


def test_the_stand_and_the_tool_changer_stand_in_the_state(system: Any) -> None:
    system.until("locked and in its stand", lambda: _places(system) == (1, IN_STAND))
    for scenario, place in (("not-in-stand", AWAY), ("no-tool", ABSENT), ("nominal", IN_STAND)):
        system.world.choose(scenario)
        system.until(scenario, lambda place=place: system.state.tool_stand == place)


def test_the_cylinder_extends_and_retracts(system: Any) -> None:
    import rospy
    from end_effector_msgs.msg import CylinderPosition

    seen: list[int] = []
    subscriber = rospy.Subscriber(
        "PositionCylinder", CylinderPosition, lambda message: seen.append(message.position)
    )
    try:
        system.until("retracted", lambda: CylinderPosition.RETRACTED in seen)
        system.grip()
        system.until("extended", lambda: CylinderPosition.EXTENDED in seen)
    finally:
        subscriber.unregister()


def _places(system: Any) -> tuple[int, int]:
    return system.state.tool_position, system.state.tool_stand
