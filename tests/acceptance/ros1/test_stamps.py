"""Frames with wrong stamps on the topic, from the name that they come from: none counts, nothing freezes."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest

from end_effector_hal.recording import read_pressures
from end_effector_hal.vocabulary import EndEffectorState

pytestmark = pytest.mark.ros
YEAR_2038 = 2_147_483_647_000_000
SCRIPT = Path(__file__).with_name("wrong_stamps.py")
RETRACTED = 1


def test_frames_of_2038_freeze_nothing_and_are_told(system: Any) -> None:
    import rospy
    from end_effector_msgs.msg import CylinderPosition

    system.grip()
    edges = system.edges()
    stamps = [str(each) for each in (YEAR_2038, 2**63 - 1, -(2**63), 0)]
    impostor = system.start("impostor", sys.executable, str(SCRIPT), *stamps)
    log = system.folder / "impostor.log"
    system.until("the frames", lambda: log.exists() and "published" in log.read_text())
    refused = "Sensor frames are refused and count for nothing: one is "
    system.until("the alarm", lambda: any(each.startswith(refused) for each in system.state.alarms))
    state = system.state
    assert (state.state, state.held) == (EndEffectorState.GRIPPED, True)
    impostor.end()
    system.until("the link", lambda: system.state.link_up and list(system.state.evidence) == [3, 3, 3])
    assert system.edges() == edges, "nothing was let go"
    seen: list[int] = []
    subscriber = rospy.Subscriber(
        "PositionCylinder", CylinderPosition, lambda message: seen.append(message.position)
    )
    try:
        assert system.run("Drop")[0] == 3
        system.until("retracted", lambda: seen and seen[-1] == RETRACTED)
    finally:
        subscriber.unregister()
    assert system.state.state == EndEffectorState.STAND_BY
    pressures = read_pressures(system.folder / "log" / "pressures.csv")
    assert max(pressures.times_s) < 3600, "no row of 2038"
