"""``eehal run`` where the system gives it no thread, nobody reads what it prints, or a standard stream is closed."""

from __future__ import annotations

import os
import resource
import select
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from end_effector_hal.arbiter import ArbiterClient
from end_effector_hal.description import load, profile_path
from end_effector_lab.demo._world import World
from end_effector_lab.processes import EEHAL
from tests.support.patience import PATIENCE_S, wait_until

pytestmark = [pytest.mark.wall, pytest.mark.timeout(240)]
BIG_STACKS = ["prlimit", f"--stack={256 << 20}"]
"""A thread that is started needs more address space than what an earlier one has left behind."""
FEW_THREADS = """
import sys, threading
left, start = int(sys.argv.pop(1)), threading._start_new_thread
def start_one(*arguments):
    global left
    left -= 1
    if left < 0:
        raise RuntimeError("can't start new thread")
    return start(*arguments)
threading._start_new_thread = start_one
from end_effector_hal.cli import main
main()
"""


@pytest.fixture
def world(tmp_path: Path) -> Iterator[World]:
    with World(load(profile_path()), "nominal", tmp_path) as running:
        yield running


class Run:
    """The command, whose input is a pipe, and its output a file."""

    def __init__(self, world: World, out: Path) -> None:
        self._out = out
        with out.open("wb") as file:
            self.process = subprocess.Popen(
                [*BIG_STACKS, *EEHAL, "run", str(world.description_path)],
                stdin=subprocess.PIPE,
                stdout=file,
                stderr=subprocess.STDOUT,
            )

    def do(self, command: str, said: str) -> None:
        """Type a command, again where a busy machine has had it refused."""

        def succeeds() -> bool:
            begun = len(self.text)
            assert self.process.stdin is not None
            self.process.stdin.write(f"{command}\n".encode())
            self.process.stdin.flush()
            return said in wait_until("an answer", lambda: self.answer(begun))

        wait_until(f"{command}: {said}", succeeds)

    def answer(self, begun: int) -> str:
        ends = (": succeeded", "refused: ", ": failed", "outcome unknown", "Traceback")
        text = self.text[begun:]
        return text if any(end in text for end in ends) else ""

    @property
    def text(self) -> str:
        return self._out.read_text()


@pytest.fixture
def run(world: World, tmp_path: Path) -> Iterator[Run]:
    running = Run(world, tmp_path / "out")
    yield running
    running.process.kill()
    running.process.communicate()


def without_memory_for_threads(pid: int) -> None:
    pages = int(Path(f"/proc/{pid}/statm").read_text().split()[0])
    most = pages * os.sysconf("SC_PAGE_SIZE") + (64 << 20)
    resource.prlimit(pid, resource.RLIMIT_AS, (most, most))


def test_a_part_is_dropped_where_no_thread_can_be_started(run: Run) -> None:
    run.do("lock", "LOCK: succeeded")
    run.do("grip", "GRIP: succeeded")
    without_memory_for_threads(run.process.pid)
    run.do("stop", "STOP: succeeded")
    run.do("drop", "RELEASE: succeeded")
    run.do("reset", "RESET: succeeded")
    run.do("grip", "GRIP: succeeded")
    run.process.terminate()
    assert run.process.wait(PATIENCE_S) == 128 + signal.SIGTERM
    assert "Traceback" not in run.text


def test_a_start_without_threads_is_a_sentence_before_anything_is_opened(world: World) -> None:
    for left in (0, 6, 7, 8):
        command = [sys.executable, "-c", FEW_THREADS, str(left), "run", str(world.description_path)]
        ended = subprocess.run(
            [*command, "--script", "lock"], capture_output=True, text=True, timeout=PATIENCE_S, check=False
        )
        assert ended.returncode == 1
        assert "gives this program no more thread. Look at its limits: ulimit -a" in ended.stderr
        assert "Traceback" not in ended.stderr
        assert "LOCK" not in ended.stdout


@pytest.mark.parametrize("as_json", [False, True], ids=["words", "json"])
def test_sigterm_ends_a_run_that_holds_a_part_while_nobody_reads(
    world: World, tmp_path: Path, as_json: bool
) -> None:
    command = [*EEHAL, "run", str(world.description_path), *["--json"] * as_json]
    reader, writer = os.pipe()
    errors = tmp_path / "errors"
    with errors.open("w") as err:
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=writer, stderr=err)
    assert process.stdin is not None
    try:
        process.stdin.write(b"lock\n" + b"grip\nwait 0.2\n" * 20)
        process.stdin.flush()
        wait_until("it grips", lambda: holds(world))
        process.stdin.write(b"status\n" * 3_000)  # more than the pipe takes
        process.stdin.flush()
        wait_until("it waits for a reader", lambda: not select.select([], [writer], [], 0)[1])
        process.terminate()
        assert process.wait(15.0) == 128 + signal.SIGTERM
    finally:
        process.kill()
        process.communicate()
        said = errors.read_text() + os.read(reader, 1 << 20).decode()
        os.close(reader)
        os.close(writer)
    assert holds(world)
    assert "Traceback" not in said
    assert as_json or "Top vacuum stay active, as declared." in said


def holds(world: World) -> bool:
    with ArbiterClient(world.socket, "look") as look:
        return sum(look.levels().values()) == 3
