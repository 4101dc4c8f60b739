"""A program that executes commands from standard input and prints ``done``, after ``failed: …`` for a failure."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

from environments import Environment

from end_effector_lab.processes import Children

START_S = 30.0
HERE = Environment()
BENCHMARKS = Path(__file__).parents[1]


class Driven:
    """One program of this kind.

    Args:
        children: starts it, and ends it.
        program: path under ``benchmarks``.
        arguments: its arguments.
        folder: receives its log.
        where: its interpreter and environment.
    """

    def __init__(
        self,
        children: Children,
        program: str,
        arguments: Sequence[object],
        folder: Path,
        where: Environment = HERE,
    ) -> None:
        self._child = children.start(
            program, [where.python, str(BENCHMARKS / program), *map(str, arguments)],
            log=folder / f"{program.replace('/', '-')}.log", env=where.env, commands=True,
        )  # fmt: skip
        self._done = self._failed = 0
        self.pid = self._child.pid

    def wait_ready(self) -> None:
        """Wait until the program accepts commands."""
        self._child.wait_until(lambda: "ready" in self._words(), timeout_s=START_S, what="it was ready")

    def tell(self, line: str) -> None:
        """Send a command to the program."""
        self._child.tell(line)

    def wait_done(self, *, expected_s: float, timeout_s: float) -> list[str]:
        """Wait until the command is done; to avoid disturbance, do not poll before ``expected_s``.

        Returns:
            the failures of this command, in words.
        """
        self._done += 1
        end = time.monotonic() + expected_s
        while (left := end - time.monotonic()) > 0:
            time.sleep(min(left, 0.5))
            if self._child.code is not None:
                break
        self._child.wait_until(
            lambda: self._words().count("done") >= self._done, timeout_s=timeout_s, what="it was done"
        )
        failed = [line for line in self._child.text().splitlines() if line.startswith("failed:")]
        new, self._failed = failed[self._failed :], len(failed)
        return new

    def _words(self) -> list[str]:
        return self._child.text().split()
