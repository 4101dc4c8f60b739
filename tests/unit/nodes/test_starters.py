"""The callbacks of a process of nodes: once, after all nodes exist and the memory was tidied, and at steady rates."""

from __future__ import annotations

import logging

import pytest

from end_effector_hal.nodes import process
from end_effector_hal.nodes.process import Starters, Ticks


def test_frames_come_after_the_memory_is_tidy(monkeypatch: pytest.MonkeyPatch) -> None:
    done: list[str] = []
    monkeypatch.setattr(process, "tune_interpreter", lambda: done.append("tidy"))
    starters = Starters()
    for name in ("the tool", "another"):
        starters.add(lambda name=name: done.append(name))  # type: ignore[misc]
    assert done == []
    starters.start()
    assert done == ["tidy", "the tool", "another"]


def test_what_is_due_together_is_called_in_one_go(monkeypatch: pytest.MonkeyPatch) -> None:
    begun = 7_000_000
    monkeypatch.setattr(process, "now_us", lambda: begun)
    monkeypatch.setattr(Ticks, "_run", lambda _: None)
    done: list[str] = []
    log = logging.getLogger("tests.ticks")
    ticks = Ticks()

    def fails() -> None:
        done.append("fails")
        raise ValueError

    for rate_hz, task in ((1, lambda: done.append("slow")), (10, lambda: done.append("quick")), (5, fails)):
        ticks.add(rate_hz, task, log)
    log.setLevel(logging.CRITICAL)
    at, gone = begun, []
    for _ in range(10):
        at = ticks.call(at)
        gone.append(at - begun)
    assert gone == [100_000 * n for n in range(1, 11)]
    assert done == ["quick", *["quick", "fails", "quick"] * 4]
    done.clear()
    assert (
        ticks.call(begun + 5_432_100) == begun + 5_500_000
    )  # after a pause of the machine: once, and in step again
    assert done == ["slow", "quick", "fails"]
    ticks.close()
    ticks.call(begun + 9_000_000)
    assert done == ["slow", "quick", "fails"]
