"""A release on a bus ends when its device has obeyed, not when the sensors show what was there before."""

from __future__ import annotations

from pathlib import Path

from end_effector_hal.codecs import load_tool
from end_effector_hal.vocabulary import EndEffectorState, Evidence
from end_effector_lab.virtual import VirtualTool
from tests.support.places import ROOT
from tests.unit.virtual.test_pending_release import Devices
from tests.unit.virtual.test_unread_outputs import TOOL, until

RELEASE_ERROR, RELEASING, STAND_BY = (
    EndEffectorState.RELEASE_ERROR,
    EndEffectorState.RELEASING,
    EndEffectorState.STAND_BY,
)


def begun(tool: VirtualTool) -> None:
    """Grip until the first output is active; its sensor shows nothing of it yet."""
    until(tool, STAND_BY)
    tool.run(1.0)
    assert tool.status.evidence[0] is Evidence.GONE
    assert tool.command("grip").accepted
    assert tool.run_until(tool.at + 20_000_000, lambda: bool(tool.edges))


def test_fingers_that_may_still_close_are_not_gone() -> None:
    """The last reading before a silence shows open fingers, and is older than what commands them to close."""
    tool = VirtualTool(load_tool(ROOT / "examples/tools/gripper_2f85/end_effector.yaml"))
    begun(tool)
    assert tool.status.evidence[0] is Evidence.PARTIAL
    tool.choose("silent-after:0")
    assert tool.command("cancel").accepted
    tool.run(30.0)
    assert tool.status.ee is RELEASE_ERROR
    assert all(tool.levels.values()), "nothing has reached the device"
    tool.choose("nominal")
    tool.run(3.0)
    assert not any(tool.levels.values()), "the release is repeated until it is obeyed"
    assert tool.command("drop").accepted
    until(tool, STAND_BY)


def test_a_release_waits_for_its_acknowledgement_whatever_the_sensor_shows(tmp_path: Path) -> None:
    """Without a part the vacuum is never there; the device hears reads, and no write."""
    path = tmp_path / "end_effector.yaml"
    path.write_text(TOOL)
    tool = VirtualTool(load_tool(path), "never-confirms:cup_a")
    devices = Devices(tool)
    begun(tool)
    devices.deaf = True
    assert tool.command("cancel").accepted
    tool.run(1.0)
    assert tool.status.ee is RELEASING
    tool.run(20.0)
    assert tool.status.ee is RELEASE_ERROR
    assert tool.levels[tool.edges[0].line]
    assert "the device of Cup a has not acknowledged it" in tool.status.reason
    devices.deaf = False
    assert tool.command("drop").accepted
    until(tool, STAND_BY)
    assert not any(tool.levels.values())


def test_a_release_that_is_acknowledged_ends_with_the_next_reading(tmp_path: Path) -> None:
    path = tmp_path / "end_effector.yaml"
    path.write_text(TOOL)
    tool = VirtualTool(load_tool(path), "never-confirms:cup_a")
    begun(tool)
    tool.run(0.3)
    at = tool.at
    assert tool.command("cancel").accepted
    assert tool.run_until(at + 200_000, lambda: tool.status.ee is STAND_BY), "two cycles of 50 ms"
