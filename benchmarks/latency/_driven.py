"""A program that does what it is told on standard input, and says ``done``; ``failed: …`` before, if it did not."""

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
    """One such program.

    Args:
        children: start it, and end it.
        program: path under ``benchmarks``.
        arguments: of it.
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
        """Wait until it obeys."""
        self._child.wait_until(lambda: "ready" in self._words(), timeout_s=START_S, what="it was ready")

    def tell(self, line: str) -> None:
        """Have it begin something."""
        self._child.tell(line)

    def wait_done(self, *, expected_s: float, timeout_s: float) -> list[str]:
        """Wait until it has done it; nothing is asked before ``expected_s``, so as not to disturb it.

        Returns:
            what failed this time, in words.
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
