"""A signal may come at any moment of the wait for the end, also twice: from a terminal, and from `ros2 launch`."""

from __future__ import annotations

import sys
import threading
from types import FrameType
from typing import Any

import pytest

from end_effector_hal.errors import RosError
from end_effector_hal.nodes.process import ProcessEnd

PATIENCE_S = 5.0
MOMENTS = 60
"""More steps of the interpreter than two looks take."""


def _ends(end: ProcessEnd, moment: int, times: int) -> bool:
    """Whether a wait comes to its end whose handler runs before its step ``moment``."""
    steps = 0

    def step(_frame: FrameType, _event: str, _arg: Any) -> Any:
        nonlocal steps
        if steps == moment:
            for _ in range(times):
                end.begin()
        steps += 1
        return step

    def run() -> None:
        sys.settrace(step)
        end.wait()

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    thread.join(0.0 if steps > moment else PATIENCE_S)
    return not thread.is_alive()


@pytest.mark.parametrize("times", [1, 2])
def test_a_signal_at_any_step_of_the_wait_ends_it(monkeypatch: pytest.MonkeyPatch, times: int) -> None:
    monkeypatch.setattr("end_effector_hal.nodes.process._process_end.LOOK_S", 0.001)
    stuck = [moment for moment in range(MOMENTS) if not _ends(ProcessEnd(20.0), moment, times)]
    assert not stuck


def test_it_ends_with_the_error_that_came_first() -> None:
    end = ProcessEnd(1000.0)
    assert not end.begun
    first = RosError("the master has gone.")
    assert end.fail(first)
    assert not end.fail(RosError("another one."))
    end.begin()
    assert end.begun
    with pytest.raises(RosError, match="the master has gone"):
        end.wait()
