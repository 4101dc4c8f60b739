"""Processes that are started are ended, whatever they do."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from end_effector_hal.errors import ArbiterError
from end_effector_lab.processes import Children
from tests.support.patience import PATIENCE_S

pytestmark = pytest.mark.wall

STUBBORN = "import signal, time; signal.signal(15, signal.SIG_IGN); print('up', flush=True); time.sleep(600)"
PARENT = f"""
import subprocess, sys, time
subprocess.Popen([sys.executable, "-c", {STUBBORN!r}], start_new_session=True)
time.sleep(600)
"""
KILLED = """
import sys, time
from pathlib import Path
from end_effector_lab.processes import Children
children = Children()
bound = children.start("bound", ["sleep", "600"], log=Path(sys.argv[1]))
free = children.start("free", ["sleep", "600"], log=Path(sys.argv[1]), outlives_us=True)
print(bound.pid, free.pid, flush=True)
time.sleep(600)
"""


def alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().split(")")[-1].split()[0] != "Z"
    except OSError:
        return False


def test_what_ignores_sigterm_is_killed(tmp_path: Path) -> None:
    with Children() as children:
        child = children.start("mule", [sys.executable, "-c", STUBBORN], log=tmp_path / "log", patience_s=0.2)
        child.wait_until(lambda: "up" in child.text(), timeout_s=PATIENCE_S, what="a word")
    assert child.code == -9


def test_what_moved_to_a_session_of_its_own_is_killed_too(tmp_path: Path) -> None:
    with Children() as children:
        child = children.start("parent", [sys.executable, "-c", PARENT], log=tmp_path / "log")
        child.wait_until(lambda: "up" in child.text(), timeout_s=PATIENCE_S, what="a word of the grandchild")
        family = children.left()
        assert len(family) == 2
        assert child.pid in family
    assert not any(alive(pid) for pid in family)


def test_an_exception_ends_them_as_well(tmp_path: Path) -> None:
    started = []

    def fail() -> None:
        with Children() as children:
            started.append(children.start("sleeper", ["sleep", "600"], log=tmp_path / "log"))
            assert alive(started[0].pid)
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert not alive(started[0].pid)


def test_whoever_is_started_ends_with_a_killed_parent_but_for_what_outlives_it(tmp_path: Path) -> None:
    parent = subprocess.Popen(
        [sys.executable, "-c", KILLED, tmp_path / "log"], stdout=subprocess.PIPE, text=True
    )
    assert parent.stdout
    bound, free = map(int, parent.stdout.readline().split())
    try:
        while not all("sleep" in Path(f"/proc/{pid}/comm").read_text() for pid in (bound, free)):
            time.sleep(0.01)
        parent.kill()
        parent.communicate()
        end = time.monotonic() + PATIENCE_S
        while alive(bound) and time.monotonic() < end:
            time.sleep(0.01)
        assert (alive(bound), alive(free)) == (False, True)
    finally:
        parent.kill()
        os.kill(free, signal.SIGKILL)


def test_nothing_else_is_touched(tmp_path: Path) -> None:
    with Children() as others:
        other = others.start("other", ["sleep", "600"], log=tmp_path / "other")
        with Children() as children:
            children.start("mine", ["sleep", "600"], log=tmp_path / "mine")
        assert alive(other.pid)
        assert alive(os.getpid())


def test_end_since_leaves_those_before(tmp_path: Path) -> None:
    with Children() as children:
        first, second, third = (
            children.start(n, ["sleep", "600"], log=tmp_path / n) for n in ("a", "b", "c")
        )
        children.end_since(second)
        assert (first.code, second.code, third.code) == (None, -15, -15)


def test_one_that_ends_before_it_is_ready_is_told_with_its_last_lines(tmp_path: Path) -> None:
    command = [sys.executable, "-c", "print('reading', flush=True); raise SystemExit('there is no chip')"]
    with Children() as children:
        child = children.start("line arbiter", command, log=tmp_path / "arbiter.log", failed=ArbiterError)
        with pytest.raises(ArbiterError) as raised:
            child.wait_until(lambda: False, timeout_s=PATIENCE_S, what="its socket")
    text = str(raised.value)
    assert text.startswith("The line arbiter ended (exit code 1) before its socket.")
    assert str(tmp_path / "arbiter.log") in text
    assert text.endswith("    there is no chip")
    assert raised.value.exit_code == 3


def test_one_that_is_never_ready(tmp_path: Path) -> None:
    with Children() as children:
        child = children.start("line arbiter", ["sleep", "9"], log=tmp_path / "log", failed=ArbiterError)
        with pytest.raises(ArbiterError, match=r"but its socket did not come within 0\.1 s"):
            child.wait_until(lambda: False, timeout_s=0.1, what="its socket")


def test_a_program_that_is_not_there(tmp_path: Path) -> None:
    with Children() as children, pytest.raises(ArbiterError, match="cannot be started: No such file"):
        children.start("ghost", ["/no/such/program"], log=tmp_path / "log", failed=ArbiterError)
