"""A status of the whole tool: of two programs, each with a time of its own."""

from __future__ import annotations

import threading
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

from end_effector_hal.control import Status
from end_effector_hal.runtime import EndEffector
from end_effector_hal.vocabulary import EndEffectorState
from tests.support.lone_program import Tool


def test_the_gripping_is_not_told_as_of_a_time_before_its_own() -> None:
    """A status of the tool changer waited in its thread; meanwhile a frame moved the gripping."""
    told: list[Status] = []
    changer = replace(Tool().program.status, at=1_000)
    gripped = replace(changer, at=21_000, ee=EndEffectorState.GRIPPED)
    tool: Any = object.__new__(EndEffector)
    tool._lock, tool._audience = threading.Lock(), SimpleNamespace(status=told.append, alarms=())
    tool._grip, tool._gripping = SimpleNamespace(status=gripped, update_peer=lambda **_: None), None
    tool._change = SimpleNamespace(status=changer)
    tool._changer_moved(changer)
    assert [(each.at, each.ee) for each in told] == [(21_000, EndEffectorState.GRIPPED)]


def test_a_status_of_the_tool_changer_does_not_anticipate_the_gripping() -> None:
    """The gripping has moved on, and its states are told in their order: not the last one first."""
    told: list[Status] = []
    standing = replace(Tool().program.status, at=1_000, ee=EndEffectorState.STAND_BY)
    gripping = replace(standing, at=2_000, ee=EndEffectorState.GRIPPING)
    gripped = replace(standing, at=3_000, ee=EndEffectorState.GRIPPED)
    tool: Any = object.__new__(EndEffector)
    tool._lock, tool._audience = threading.Lock(), SimpleNamespace(status=told.append, alarms=())
    tool._grip = SimpleNamespace(status=gripped, update_peer=lambda **_: None)
    tool._change = SimpleNamespace(status=standing, update_peer=lambda **_: None)
    tool._gripper_moved(standing)
    tool._changer_moved(replace(standing, at=2_500))
    tool._gripper_moved(gripping)
    tool._gripper_moved(gripped)
    assert [each.ee.name for each in told] == ["STAND_BY", "STAND_BY", "GRIPPING", "GRIPPED"]
