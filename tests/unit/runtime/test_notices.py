"""A notice about a listener is told with the status that was published last."""

from __future__ import annotations

import threading
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

from end_effector_hal.control import EventKind, Status, ToolEvent
from end_effector_hal.runtime import EndEffector
from end_effector_hal.vocabulary import Alarm, EndEffectorState
from tests.support.lone_program import Tool


def test_a_notice_repeats_no_event_and_does_not_anticipate_what_is_published_next() -> None:
    """The program is further, and its states are told in their order: not the last one first."""
    told: list[Status] = []
    began = ToolEvent(1_000, EventKind.STATE_CHANGED, old=0, new=6)
    standing = replace(Tool().program.status, at=1_000, ee=EndEffectorState.STAND_BY, events=(began,))
    gripping = replace(standing, at=2_000, ee=EndEffectorState.GRIPPING, events=())
    tool: Any = object.__new__(EndEffector)
    tool._lock, tool._latest = threading.Lock(), None
    tool._audience = SimpleNamespace(put=told.append, alarms=())
    tool._follow(SimpleNamespace(status=gripping))
    tool._moved(standing)
    tool._audience.alarms = (notice := Alarm("listener.failed", "hal", {"text": "it raised."}),)
    tool._audience_changed()
    tool._moved(gripping)
    assert [(each.ee.name, each.events) for each in told] == [
        ("STAND_BY", (began,)), ("STAND_BY", ()), ("GRIPPING", ()),
    ]  # fmt: skip
    assert [notice in each.alarms for each in told] == [False, True, True]
