"""Everything that the demo started, to be ended whatever happens."""

from __future__ import annotations

import os
import signal
import time
import uuid
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Self

from end_effector_hal.errors import ReportedError

from ._child import Child

_MARK = "EEHAL_DEMO"
_GONE_S = 2.0
"""A process that was killed has gone by then."""


class Children:
    """Starts processes and ends them in reverse order, with all of their descendants.

    roslaunch puts its nodes into sessions of their own, so each descendant is known by a mark in its
    environment.

    Args:
        env: added to the environment of each.
    """

    def __init__(self, env: Mapping[str, str] | None = None) -> None:
        self._mark = uuid.uuid4().hex
        self.env = {**os.environ, **(env or {}), _MARK: self._mark}
        self._children: list[tuple[Child, int, float]] = []

    def start(
        self,
        name: str,
        command: Sequence[str],
        *,
        log: Path,
        failed: type[ReportedError] = ReportedError,
        env: Mapping[str, str] | None = None,
        end_by: int = signal.SIGTERM,
        patience_s: float = 5.0,
        commands: bool = False,
    ) -> Child:
        """Start one; see `Child`. ``end_by`` asks it to end; after ``patience_s`` it is killed."""
        child = Child(
            name, command, log=log, env={**self.env, **(env or {})}, failed=failed, commands=commands
        )
        self._children.append((child, end_by, patience_s))
        return child

    def end_since(self, first: Child) -> None:
        """End this one and those that were started after it."""
        while any(child is first for child, _, _ in self._children):
            self._end_last()

    def end(self) -> None:
        """End all of them; may be called again."""
        while self._children:
            self._end_last()
        end = time.monotonic() + _GONE_S
        while (left := self.left()) and time.monotonic() < end:
            for pid in left:
                with suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
            time.sleep(0.01)

    def _end_last(self) -> None:
        child, end_by, patience_s = self._children[-1]
        child.end(signal_number=end_by, patience_s=patience_s)
        self._children.pop()

    def left(self) -> list[int]:
        """Process ids of descendants that still run."""
        mark = f"{_MARK}={self._mark}".encode()
        return [
            pid for pid in map(int, filter(str.isdigit, os.listdir("/proc"))) if mark in _environment(pid)
        ]

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.end()


def _environment(pid: int) -> list[bytes]:
    try:
        return Path(f"/proc/{pid}/environ").read_bytes().split(b"\0")
    except OSError:
        return []
