"""``eehal run`` where the system gives it no thread, nobody reads what it prints, or a standard stream is closed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from end_effector_hal.arbiter import ArbiterClient
from end_effector_lab.demo._world import World
from end_effector_lab.processes import EEHAL
from tests.support.patience import PATIENCE_S, wait_until

pytestmark = [pytest.mark.wall, pytest.mark.timeout(240)]
FEW_THREADS = """
import signal, sys, threading
left, start = int(sys.argv.pop(1)), threading._start_new_thread
def start_one(*arguments):
    global left
    left -= 1
    if left < 0:
        raise RuntimeError("can't start new thread")
    return start(*arguments)
def no_more(*_):
    global left
    left = 0
threading._start_new_thread = start_one
signal.signal(signal.SIGUSR1, no_more)
from end_effector_hal.cli import main
main()
"""
"""So many threads can be started, and none after SIGUSR1: root has no limit of processes to meet."""


DEAF = """
import signal, sys, threading
sys.argv.pop(1)
threading.Thread(target=threading.Event().wait, daemon=True).start()
signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM})
from end_effector_hal.cli import main
main()
"""
"""No signal interrupts the main thread, which runs their handlers."""


class Run:
    """The command, whose input is a pipe, and its output a file."""

    def __init__(self, world: World, out: Path, code: str = FEW_THREADS) -> None:
        self._out = out
        with out.open("wb") as file:
            self.process = subprocess.Popen(
                [sys.executable, "-c", code, "1000", "run", str(world.description_path)],
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


def test_a_part_is_dropped_where_no_thread_can_be_started(run: Run) -> None:
    run.do("lock", "LOCK: succeeded")
    run.do("grip", "GRIP: succeeded")
    run.process.send_signal(signal.SIGUSR1)
    run.do("stop", "STOP: succeeded")
    run.do("drop", "DROP: succeeded")
    run.do("reset", "RESET: succeeded")
    run.do("grip", "GRIP: succeeded")
    run.process.terminate()
    assert run.process.wait(PATIENCE_S) == 128 + signal.SIGTERM
    assert "Traceback" not in run.text


def test_sigterm_ends_a_run_whose_reading_it_does_not_interrupt(world: World, tmp_path: Path) -> None:
    """As one that arrives just before the program waits for a line: another thread receives it."""
    running = Run(world, tmp_path / "out", DEAF)
    try:
        running.do("lock", "LOCK: succeeded")
        running.process.terminate()
        assert running.process.wait(PATIENCE_S) == 128 + signal.SIGTERM
    finally:
        running.process.kill()
        running.process.communicate()


def test_a_start_without_threads_is_a_sentence_before_anything_is_opened(world: World) -> None:
    for left in (0, 3, 4):
        command = [sys.executable, "-c", FEW_THREADS, str(left), "run", str(world.description_path)]
        ended = subprocess.run(
            [*command, "--script", "lock"], capture_output=True, text=True, timeout=PATIENCE_S, check=False
        )
        assert ended.returncode == 1
        assert "gives this program no more thread. Look at its limits: ulimit -a" in ended.stderr
        assert "Traceback" not in ended.stderr
        assert "LOCK" not in ended.stdout


def test_a_script_whose_output_is_lost_is_carried_out_and_ends_with_2(world: World) -> None:
    with Path("/dev/full").open("w") as full:
        ended = subprocess.run(
            [*EEHAL, "run", str(world.description_path), "--script", "lock; grip"],
            stdout=full, stderr=subprocess.PIPE, text=True, timeout=PATIENCE_S, check=False,
        )  # fmt: skip
    assert ended.returncode == 2
    assert ended.stderr.splitlines()[-1] == "The output cannot be written: No space left on device."
    assert holds(world)


@pytest.mark.parametrize("as_json", [False, True], ids=["words", "json"])
def test_sigterm_ends_a_run_that_holds_a_part_while_nobody_reads(
    world: World, tmp_path: Path, as_json: bool
) -> None:
    command = [*EEHAL, "run", str(world.description_path), *["--json"] * as_json]
    gripped = '"command": "GRIP", "succeeded": true' if as_json else "GRIP: succeeded"
    reader, writer = os.pipe()
    with (tmp_path / "errors").open("w") as err:
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=writer, stderr=err)
    assert process.stdin is not None
    try:
        process.stdin.write(b"lock\n" + b"grip\nwait 0.2\n" * 20)
        process.stdin.flush()
        said = ""
        while gripped not in said:
            said += os.read(reader, 65_536).decode()
        fill(writer)
        process.stdin.write(b"status\n")
        process.stdin.flush()
        process.terminate()
        assert process.wait(15.0) == 128 + signal.SIGTERM
    finally:
        process.kill()
        process.communicate()
        os.close(reader)
        os.close(writer)
    assert holds(world)
    errors = (tmp_path / "errors").read_text()
    assert "Traceback" not in errors
    assert as_json or "Top vacuum stay active, as declared." in errors


def fill(pipe: int) -> None:
    """Until it takes no byte more."""
    own = os.open(f"/proc/self/fd/{pipe}", os.O_WRONLY | os.O_NONBLOCK)
    for size in (4096, 1):
        with suppress(BlockingIOError):
            while True:
                os.write(own, b"x" * size)
    os.close(own)


def holds(world: World) -> bool:
    with ArbiterClient(world.socket, "look") as look:
        return sum(look.levels().values()) == 3
