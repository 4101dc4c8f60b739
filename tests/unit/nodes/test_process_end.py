"""A signal may come at any moment of the wait for the end, also twice: from a terminal, and from `ros2 launch`."""

from __future__ import annotations

import faulthandler
import subprocess
import sys
import threading
from collections.abc import Iterator
from types import FrameType
from typing import Any

import pytest

from end_effector_hal.errors import RosError
from end_effector_hal.nodes.process import ProcessEnd
from tests.support.nightly import first_of

PATIENCE_S = 5.0
MOMENTS = 60
"""More steps of the interpreter than two looks take."""


@pytest.fixture(autouse=True)
def _this_process_goes_on() -> Iterator[None]:
    yield
    faulthandler.cancel_dump_traceback_later()


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
    thread.join(PATIENCE_S)
    return not thread.is_alive()


@pytest.mark.parametrize("times", [1, 2])
def test_a_signal_at_any_step_of_the_wait_ends_it(monkeypatch: pytest.MonkeyPatch, times: int) -> None:
    monkeypatch.setattr("end_effector_hal.nodes.process.LOOK_S", 0.001)
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


HANGS = """
from end_effector_hal.nodes import process
from end_effector_hal.nodes.process import ProcessEnd, leave_within
{left}
import ctypes
def hangs_with_the_lock_of_the_interpreter():
    ctypes.PyDLL(None).sleep(100)
hangs_with_the_lock_of_the_interpreter()
"""


LEFT = """
process.LONGEST_S = 0.2
end = ProcessEnd(1000.0)
end.begin()
end.wait()
"""
SIGNALLED = """
process.LONGEST_S = 0.2
ProcessEnd(1000.0).begin()
"""


def hung(left: str) -> tuple[int, str]:
    """Exit code and error output of a process that hangs."""
    program = [sys.executable, "-c", HANGS.format(left=left)]
    done = subprocess.run(program, capture_output=True, text=True, timeout=30, check=False)
    return done.returncode, done.stderr


@pytest.mark.parametrize("left", [LEFT, SIGNALLED])
def test_what_hangs_at_its_end_is_left_by_force_and_says_where(left: str) -> None:
    code, said = hung(left)
    assert code == 1
    assert "hangs_with_the_lock_of_the_interpreter" in said


@pytest.mark.parametrize("code", first_of([3, 0], thinned=0))
def test_a_middleware_that_hangs_is_left_without_a_word(code: int) -> None:
    assert hung(f"leave_within(1, {code})") == (code, "")
