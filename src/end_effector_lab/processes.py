"""Starts and watches processes, and reliably ends them with all their descendants."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import threading
import time
import uuid
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Self, TypedDict, Unpack

from end_effector_hal.errors import ReportedError

EEHAL = (sys.executable, "-c", "from end_effector_hal.cli import main; main()")
"""The command that starts `eehal`, independent of the PATH."""

_TICK_S = 0.02
_LAST_LINES = 8


class ChildOptions(TypedDict, total=False):
    """Optional arguments of a `Child`."""

    failed: type[ReportedError]
    end_by: int
    patience_s: float
    outlives_us: bool
    commands: bool


class Child:
    """A process in a session of its own, with its output in a log file.

    Args:
        name: name for sentences, such as ``line arbiter``.
        command: program and arguments.
        log: receives standard output and standard error.
        env: its whole environment.
        end_by: signal that ends it; the kernel sends it, too, when this process is killed, so that no orphan keeps a
            port or a socket.
        patience_s: time after that signal, then it is killed, s.
        outlives_us: whether it keeps running when this process is killed: a line arbiter has last wills to execute.
        commands: whether it reads commands from standard input, see `tell`; else standard input is empty.
        failed: the type of the errors that are raised.

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
        end_by: int = signal.SIGTERM,
        patience_s: float = 5.0,
        outlives_us: bool = False,
        commands: bool = False,
    ) -> None:
        self.name, self.log, self._failed = name, log, failed
        self._end_by, self._patience_s = end_by, patience_s
        dies_by = None if outlives_us else end_by
        try:
            with log.open("ab") as output:
                self._process = subprocess.Popen(
                    [*_bound_to_us(command[0], env, dies_by), *command],
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
        """The id of the process and of its group."""
        return self._process.pid

    @property
    def code(self) -> int | None:
        """The exit code; None while it runs."""
        return self._process.poll()

    def text(self) -> str:
        """Return the output so far."""
        return self.log.read_text(encoding="utf-8", errors="replace") if self.log.exists() else ""

    def tell(self, line: str) -> None:
        """Write a line to its standard input; raises if it has ended."""
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(f"{line}\n".encode())
            self._process.stdin.flush()
        except BrokenPipeError:
            raise self.error(f"The {self.name} has ended.") from None

    def wait_until(self, ready: Callable[[], bool], *, timeout_s: float, what: str) -> None:
        """Wait until ``ready`` returns True; raises if the process ends first, or the time is over.

        Args:
            ready: called repeatedly.
            timeout_s: longest wait.
            what: a phrase such as ``its socket``, for the message.
        """
        end = time.monotonic() + timeout_s
        while not ready():
            if self.code is not None:
                raise self.error(f"The {self.name} ended (exit code {self.code}) before {what}.")
            if time.monotonic() > end:
                raise self.error(f"The {self.name} runs, but {what} did not come within {timeout_s:g} s.")
            time.sleep(_TICK_S)

    def wait_for_end(self, *, timeout_s: float) -> int:
        """Wait until it has ended by itself; return its exit code. Raises if the time is over."""
        try:
            return self._process.wait(timeout_s)
        except subprocess.TimeoutExpired:
            raise self.error(f"The {self.name} did not end within {timeout_s:g} s.") from None

    def error(self, what: str) -> ReportedError:
        """Return the error to raise: a sentence with the last lines of the log."""
        lines = [line for line in self.text().splitlines() if line.strip()][-_LAST_LINES:]
        said = "".join(f"\n    {line}" for line in lines)
        return self._failed(
            what, todo=f"Its log, {self.log}, ends with:{said}" if said else f"Its log is empty: {self.log}"
        )

    def end(self, *, signal_number: int | None = None, patience_s: float | None = None) -> None:
        """End the process properly, then by force; may be called again. Default: as it was started."""
        if self.code is None:
            _send(self.pid, signal_number or self._end_by)
            with suppress(subprocess.TimeoutExpired):
                self._process.wait(self._patience_s if patience_s is None else patience_s)
        # the rest of its session
        _send(self.pid, signal.SIGKILL)
        self._process.wait()
        if self._process.stdin is not None:
            with suppress(BrokenPipeError):
                self._process.stdin.close()


def _bound_to_us(program: str, env: Mapping[str, str], signal_number: int | None) -> list[str]:
    """Return a command prefix that makes the kernel send a signal at the death of this process (prctl,
    PR_SET_PDEATHSIG).

    It is empty if util-linux lacks the program, if the command does not exist (Popen reports that), and outside the
    main thread, whose end would count as the death.
    """
    setpriv, found = shutil.which("setpriv"), shutil.which(program, path=env.get("PATH"))
    in_main = threading.current_thread() is threading.main_thread()
    if signal_number is None or not setpriv or not found or not in_main:
        return []
    return [setpriv, "--pdeathsig", signal.Signals(signal_number).name.removeprefix("SIG")]


def _send(group: int, number: int) -> None:
    try:
        os.killpg(group, number)
    except ProcessLookupError:
        return
    except PermissionError:
        return  # what is left of the group is a zombie that is not ours to reap


_MARK = "EEHAL_DEMO"
_GONE_S = 2.0
"""Time within which a killed process disappears, s."""


class Children:
    """Starts processes and ends them in reverse order, with all of their descendants.

    roslaunch puts its nodes into sessions of their own, so descendants are found by a mark in their environment.

    Args:
        env: added to the environment of each process.
    """

    def __init__(self, env: Mapping[str, str] | None = None) -> None:
        self._mark = uuid.uuid4().hex
        self.env = {**os.environ, **(env or {}), _MARK: self._mark}
        self._children: list[Child] = []

    def start(
        self,
        name: str,
        command: Sequence[str],
        *,
        log: Path,
        env: Mapping[str, str] | None = None,
        **more: Unpack[ChildOptions],
    ) -> Child:
        """Start a process; see `Child`. ``env`` is added to the environment of all."""
        child = Child(name, command, log=log, env={**self.env, **(env or {})}, **more)
        self._children.append(child)
        return child

    def end_since(self, first: Child) -> None:
        """End this process and those that were started after it."""
        while any(child is first for child in self._children):
            self._end_last()

    def end(self) -> None:
        """End all processes; may be called again."""
        while self._children:
            self._end_last()
        end = time.monotonic() + _GONE_S
        while (left := self.left()) and time.monotonic() < end:
            for pid in left:
                with suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
            time.sleep(0.01)

    def _end_last(self) -> None:
        self._children[-1].end()
        self._children.pop()

    def left(self) -> list[int]:
        """Return the ids of descendants that still run."""
        mark = f"{_MARK}={self._mark}".encode()
        return [
            pid for pid in map(int, filter(str.isdigit, os.listdir("/proc"))) if mark in _environment(pid)
        ]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.end()


def _environment(pid: int) -> list[bytes]:
    try:
        return Path(f"/proc/{pid}/environ").read_bytes().split(b"\0")
    except OSError:
        return []
