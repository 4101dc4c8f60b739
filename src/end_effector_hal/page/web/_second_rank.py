"""Limits for processes that read recordings, so that a tool on the same machine has priority."""

from __future__ import annotations

import os
import resource
from contextlib import suppress
from pathlib import Path

_NICE = 10
"""Niceness: a tenth of the processor beside a busy process, so no tool is late and reading still advances."""
MOST_CPU_S = 180
"""Processor time limit, independent of other load; half an hour of a tool needs 20 s."""
_MOST_BYTES = 4 << 30
"""Address space limit, bytes; half an hour of a tool at 50 Hz needs a quarter of it."""


def step_back(pid: int, *, session: bool = False) -> None:
    """Lower the priority of a process that has not started its threads yet.

    Args:
        pid: id of the process.
        session: whether it leads its own session: Linux may share the processor between sessions first (autogroup),
            and within them by niceness.
    """
    with suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, pid, max(_NICE, os.getpriority(os.PRIO_PROCESS, pid)))
    if session:
        with suppress(OSError):
            Path(f"/proc/{pid}/autogroup").write_text(str(_NICE), encoding="ascii")


def bound(pid: int) -> None:
    """Limit a reader's memory and processor time, so that a huge recording ends only its reader."""
    cpu = (MOST_CPU_S, MOST_CPU_S + 5)  # at the first it gets SIGXCPU, which says why it ended
    for limit, most in ((resource.RLIMIT_AS, (_MOST_BYTES, _MOST_BYTES)), (resource.RLIMIT_CPU, cpu)):
        with suppress(OSError):
            resource.prlimit(pid, limit, most)
