"""Gripping and the tool changer exclude each other from the microsecond in which one of them begins."""

from __future__ import annotations

from pathlib import Path

from end_effector_hal.description import Description
from end_effector_hal.verification.replay import review
from end_effector_hal.vocabulary import ChangerState, EndEffectorState
from tests.support.recorded_tool import RecordedTool
from tests.support.virtual_tool import VirtualTool

LOOSE = "IL-05: "


def test_each_excludes_the_other_at_once(verdin: Description) -> None:
    tool = VirtualTool(verdin)
    tool.play(1.0, "unlock")
    assert tool.command("grip").reason.startswith(LOOSE)
    while tool.status.changer is not ChangerState.LOCKED:
        assert tool.command("grip").reason.startswith(LOOSE)
        tool.run(0.01)
    assert tool.command("grip").accepted
    assert not tool.command("unlock").accepted


def test_a_run_with_both_is_replayed_with_the_same_decisions(tmp_path: Path) -> None:
    tool = RecordedTool(tmp_path)
    tool.run(1.0)
    for command, unlock in (("unlock", True), ("grip", False)):
        assert tool.command(command).accepted
        tool._told(tool.controller.refused(tool.at, unlock=unlock))
        tool.run(3.0)
    assert tool.status.ee is EndEffectorState.STAND_BY
    for command, seconds in (("unlock", 1.0), ("lock", 2.0), ("grip", 3.0), ("drop", 3.0)):
        assert tool.command(command).accepted, command
        tool.run(seconds)
    reviewed = review(tool.trace())
    assert (reviewed.replay.difference, reviewed.objections) == (None, ())
    assert reviewed.replay.compared > 50
