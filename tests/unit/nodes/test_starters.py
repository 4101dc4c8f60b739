"""When a process of nodes gets its first frame: after all nodes exist and the memory was tidied."""

from __future__ import annotations

import pytest

from end_effector_hal.nodes import process
from end_effector_hal.nodes.process import Starters


def test_frames_come_after_the_memory_is_tidy(monkeypatch: pytest.MonkeyPatch) -> None:
    done: list[str] = []
    monkeypatch.setattr(process, "tune_interpreter", lambda: done.append("tidy"))
    starters = Starters()
    for name in ("the tool", "another"):
        starters.add(lambda name=name: done.append(name))  # type: ignore[misc]
    assert done == []
    starters.start()
    assert done == ["tidy", "the tool", "another"]
