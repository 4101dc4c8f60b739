"""A process that the demo starts and certainly ends."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from end_effector_hal.errors import ReportedError

_TICK_S = 0.02
_LAST_LINES = 8


class Child:
    """A process in a session of its own, with its output in a log file.

    Args:
        name: for sentences, such as ``line arbiter``.
        command: program and arguments.
        log: receives standard output and standard error.
        env: its whole environment.
        commands: it reads commands from standard input, see `tell`; else that is empty.
        failed: the kind of error to raise when it does not do what it should.

    Raises:
        ReportedError: it cannot be started.
    """

    def __init__(
        self,
        name: str,
        command: Sequence[str],
        *,
        log: Path,
        env: Mapping[str, str],
        failed: type[ReportedError] = ReportedError,
        commands: bool = False,
    ) -> None:
        self.name, self.log, self._failed = name, log, failed
        try:
            with log.open("ab") as output:
                self._process = subprocess.Popen(
                    list(command),
                    stdin=subprocess.PIPE if commands else subprocess.DEVNULL,
                    stdout=output,
                    stderr=subprocess.STDOUT,
                    env=dict(env),
                    start_new_session=True,
                )
        except OSError as error:
            raise failed(f"The {name} cannot be started: {error.strerror}.", where=command[0]) from None

    @property
    def pid(self) -> int:
        """Of the process, and of its group."""
        return self._process.pid

    @property
    def code(self) -> int | None:
        """Its exit code; None: it runs."""
        return self._process.poll()

    def text(self) -> str:
        """What it has said so far."""
        return self.log.read_text(encoding="utf-8", errors="replace") if self.log.exists() else ""

    def tell(self, line: str) -> None:
        """Give it a line on its standard input; raises when it has ended."""
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(f"{line}\n".encode())
            self._process.stdin.flush()
        except BrokenPipeError:
            raise self.error(f"The {self.name} has ended.") from None

    def wait_until(self, ready: Callable[[], bool], *, timeout_s: float, what: str) -> None:
        """Wait until ``ready``; raises when the process ends before, or the time is over.

        Args:
            ready: asked again and again.
            timeout_s: longest wait.
            what: a phrase such as ``its socket``, for the sentence.
        """
        end = time.monotonic() + timeout_s
        while not ready():
            if self.code is not None:
                raise self.error(f"The {self.name} ended (exit code {self.code}) before {what}.")
            if time.monotonic() > end:
                raise self.error(f"The {self.name} runs, but {what} did not come within {timeout_s:g} s.")
            time.sleep(_TICK_S)

    def wait_for_end(self, *, timeout_s: float) -> int:
        """Wait until it has ended by itself; its exit code. Raises when the time is over."""
        try:
            return self._process.wait(timeout_s)
        except subprocess.TimeoutExpired:
            raise self.error(f"The {self.name} did not end within {timeout_s:g} s.") from None

    def error(self, what: str) -> ReportedError:
        """The error to raise: a sentence with the last lines of the log."""
        lines = [line for line in self.text().splitlines() if line.strip()][-_LAST_LINES:]
        said = "".join(f"\n    {line}" for line in lines)
        return self._failed(
            what, todo=f"Its log, {self.log}, ends with:{said}" if said else f"Its log is empty: {self.log}"
        )

    def end(self, *, signal_number: int = signal.SIGTERM, patience_s: float = 5.0) -> None:
        """End it in good order, then by force; may be called again."""
        if self.code is None:
            _send(self.pid, signal_number)
            with suppress(subprocess.TimeoutExpired):
                self._process.wait(patience_s)
        # whoever is left of its session
        _send(self.pid, signal.SIGKILL)
        self._process.wait()
        if self._process.stdin is not None:
            with suppress(BrokenPipeError):
                self._process.stdin.close()


def _send(group: int, number: int) -> None:
    try:
        os.killpg(group, number)
    except ProcessLookupError:
        return
    except PermissionError:
        return  # what is left of the group is a zombie that is not ours to reap
