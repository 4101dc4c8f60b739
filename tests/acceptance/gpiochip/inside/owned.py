"""A line arbiter in a process of its own, to be killed."""

from __future__ import annotations

import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from end_effector_hal.arbiter import ArbiterClient

PROGRAM = """
import sys
from pathlib import Path
from end_effector_hal.arbiter import ArbiterServer, Policy
from end_effector_hal.wires.lines import GpiodLines
socket, *lines = sys.argv[1:]
with ArbiterServer(GpiodLines(), Path(socket), Policy(lines)) as arbiter:
    arbiter.serve(lambda _: print("ready", flush=True))
"""
PATIENCE_S = 60.0


class Arbiter:
    """The real arbiter on the real chip, without interlocks, and a client whose will is to hold."""

    def __init__(self, lines: Sequence[str]) -> None:
        self._lines = list(lines)

    def __enter__(self) -> Arbiter:
        socket = Path(tempfile.mkdtemp()) / "arbiter"
        self.process = subprocess.Popen(
            [sys.executable, "-c", PROGRAM, str(socket), *self._lines], stdout=subprocess.PIPE, text=True
        )
        assert self.process.stdout is not None
        assert self.process.stdout.readline() == "ready\n"
        self._client = ArbiterClient(socket, "test", self._lines, timeout_s=20, patience_s=PATIENCE_S)
        return self

    def __exit__(self, *_: object) -> None:
        self._client.close()
        self.process.terminate()
        self.process.communicate(timeout=PATIENCE_S)

    def levels(self) -> dict[str, bool]:
        return self._client.levels()

    def set(self, levels: Mapping[str, bool]) -> None:
        """Returns when it is so: a valve that has just been switched waits (IL-10)."""
        self._client.set(levels)
        end = time.monotonic() + PATIENCE_S
        while not levels.items() <= self.levels().items():
            assert time.monotonic() < end
            time.sleep(0.01)

    def kill(self) -> None:
        """SIGKILL; it has gone when this returns."""
        self.process.send_signal(signal.SIGKILL)
        self.process.wait(PATIENCE_S)
