"""The workers that a command is asked for."""

from __future__ import annotations

import os

from ._local import local_workers
from ._workers import Workers


def open_workers(jobs: int | None) -> Workers:
    """Processes of this machine; None: one for each processor."""
    return local_workers(jobs or len(os.sched_getaffinity(0)))
