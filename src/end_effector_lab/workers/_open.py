"""The workers that a command is asked for."""

from __future__ import annotations

import os

from end_effector_hal.errors import UsageError

from ._local import local_workers
from ._workers import Workers

MOST_JOBS, MOST_EACH = 8, 4
"""So many may be asked for on any machine, or for each processor; each takes memory of its own."""


def open_workers(jobs: int | None) -> Workers:
    """Processes of this machine; None: one for each processor; raises UsageError if they are too many."""
    here = len(os.sched_getaffinity(0))
    most = max(MOST_JOBS, MOST_EACH * here)
    if jobs is not None and jobs > most:
        raise UsageError(
            f"{jobs} processes are too many for this machine.", where="--jobs",
            todo=f"At most {most}; without --jobs it is one for each of its processors.",
        )  # fmt: skip
    return local_workers(jobs or here)
