"""Who reads recordings stands behind a tool that runs on the same machine."""

from __future__ import annotations

import os
import resource
from contextlib import suppress
from pathlib import Path

_NICE = 10
"""A tenth of the processor beside one who wants it all: no tool is late, and a recording is read on a busy machine."""
MOST_CPU_S = 180
"""Of a processor, whatever others do: half an hour of a tool takes 20 s."""
_MOST_BYTES = 4 << 30
"""Of address space: half an hour of a tool at 50 Hz takes a quarter."""


def step_back(pid: int, *, session: bool = False) -> None:
    """A process whose threads are still to come gets what the others leave of the processor.

    Args:
        pid: of the process.
        session: whether it leads a session of its own: Linux may share the processor between sessions first
            (autogroup), and within them by niceness.
    """
    with suppress(OSError):
        os.setpriority(os.PRIO_PROCESS, pid, max(_NICE, os.getpriority(os.PRIO_PROCESS, pid)))
    if session:
        with suppress(OSError):
            Path(f"/proc/{pid}/autogroup").write_text(str(_NICE), encoding="ascii")


def bound(pid: int) -> None:
    """A recording that is larger than all bounds of a reader ends its reader, and nothing else on the machine."""
    cpu = (MOST_CPU_S, MOST_CPU_S + 5)  # at the first it gets SIGXCPU, which says why it ended
    for limit, most in ((resource.RLIMIT_AS, (_MOST_BYTES, _MOST_BYTES)), (resource.RLIMIT_CPU, cpu)):
        with suppress(OSError):
            resource.prlimit(pid, limit, most)
