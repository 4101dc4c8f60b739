"""When a node gets its first frame: after the memory was tidied, and its sender begins last."""

from __future__ import annotations

import pytest

from end_effector_hal.nodes.process import Starters, _starters


def test_frames_come_after_the_memory_is_tidy_and_their_source_begins_last(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    done: list[str] = []
    monkeypatch.setattr(_starters, "tune_interpreter", lambda: done.append("tidy"))
    starters = Starters()
    starters.add(lambda: done.append("the reader of the sensors"), last=True)
    for node in ("Grip", "Position"):
        starters.add(lambda node=node: done.append(node))  # type: ignore[misc]
    assert done == []
    starters.start()
    assert done == ["tidy", "Grip", "Position", "the reader of the sensors"]
