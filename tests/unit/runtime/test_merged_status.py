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
    tool._grip = SimpleNamespace(status=gripped, update_peer=lambda **_: None)
    tool._change = SimpleNamespace(status=changer)
    tool._changer_moved(changer)
    assert [(each.at, each.ee) for each in told] == [(21_000, EndEffectorState.GRIPPED)]
