"""In the guest, on the chip that the testbench is: the gpiod back-end, and arbiters that die."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable

import pytest

from end_effector_hal.errors import LineBusyError
from end_effector_hal.wires.lines import GpiodLines
from tests.acceptance.gpiochip.inside.owned import Arbiter
from tests.support.line_backend_tests import LineBackendConformance

A, B, C = "SODIMM_206", "SODIMM_208", "SODIMM_212"


class TestBackend(LineBackendConformance):
    names = (A, B, C)
    keeps_level = False  # a line that is given back has no direction any more

    @pytest.fixture
    def make(self) -> Callable[[], GpiodLines]:
        return GpiodLines


def test_a_killed_arbiter_drops_its_lines() -> None:
    with Arbiter([A, B, C]) as arbiter:
        arbiter.set({A: True, C: True})
        assert arbiter.levels() == {A: True, B: False, C: True}
        arbiter.kill()
    with Arbiter([A, B, C]) as arbiter:
        assert arbiter.levels() == {A: False, B: False, C: False}, "nothing is activated by a start"


def test_two_arbiters_on_one_chip() -> None:
    with Arbiter([A, B]) as arbiter:
        with pytest.raises(LineBusyError) as caught:
            GpiodLines().request([B, C])
        arbiter.set({B: True})
        assert arbiter.levels() == {A: False, B: True}, "the first one does not notice"
    assert f"{B} is held by end-effector-hal." in str(caught.value)
    assert f"pid {arbiter.process.pid} (" in str(caught.value)


def test_the_command_says_who_holds_the_lines(tool: str) -> None:
    eehal = [sys.executable, "-c", "from end_effector_hal.cli import main; main()"]
    with Arbiter([A]) as arbiter:
        second = subprocess.run(
            [*eehal, "arbiter", tool], capture_output=True, text=True, timeout=120, check=False
        )
        doctor = subprocess.run(
            [*eehal, "doctor", tool, "--only", "lines"],
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )
    assert second.returncode == 3
    assert f"{A} is held by end-effector-hal." in second.stderr
    assert f"pid {arbiter.process.pid}" in second.stderr
    assert "Traceback" not in second.stderr
    assert f"{A} = /dev/gpiochip0 line 0, output, held by the line arbiter" in doctor.stdout
    assert "SODIMM_210 = /dev/gpiochip0 line 2, input, free" in doctor.stdout
