"""Stops a process, and waits until it stands still: its threads go on until one of them has taken the signal."""

from __future__ import annotations

import os
import signal
from contextlib import suppress
from pathlib import Path

from .patience import wait_until


def stop(pid: int) -> None:
    """Stop all threads of a process."""
    os.kill(pid, signal.SIGSTOP)
    wait_until(f"process {pid} stands still", lambda: all(state == "T" for state in _states(pid)))


def _states(pid: int) -> list[str]:
    states = []
    for stat in Path(f"/proc/{pid}/task").glob("*/stat"):
        with suppress(OSError):  # a thread may end meanwhile
            states.append(stat.read_text().rpartition(")")[2].split()[0])
    return states
