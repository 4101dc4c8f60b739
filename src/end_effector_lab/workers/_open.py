"""The workers that a command is asked for."""

from __future__ import annotations

import os

from end_effector_hal.errors import UsageError

from ._local import local_workers
from ._workers import Workers

MOST_JOBS, MOST_EACH = 8, 4
"""So many may be asked for on any machine, or for each processor; each takes memory of its own."""


def cluster_workers(address: str) -> Workers:
    """The workers of a cluster of dask.distributed.

    Entering it raises WorkersError when the scheduler cannot be reached, has no worker, or one of them does not fit.

    Args:
        address: of its scheduler, such as ``tcp://10.0.0.1:8786``.

    Raises:
        ModuleNotFoundError: dask.distributed, the extra `cluster`, is not installed.
    """
    from ._cluster import ClusterWorkers

    return ClusterWorkers(address)


def open_workers(scheduler: str | None, jobs: int | None) -> Workers:
    """The cluster of a scheduler, or processes of this machine; no jobs given: one for each processor.

    Raises:
        UsageError: both are given, or the jobs are too many.
    """
    if scheduler and jobs:
        raise UsageError(
            "--scheduler and --jobs exclude each other.", todo="Leave --jobs out, or --scheduler."
        )
    if scheduler:
        return cluster_workers(scheduler)
    here = len(os.sched_getaffinity(0))
    most = max(MOST_JOBS, MOST_EACH * here)
    if jobs is not None and jobs > most:
        raise UsageError(
            f"{jobs} processes are too many for this machine.", where="--jobs",
            todo=f"At most {most}; without --jobs it is one for each of its processors.",
        )  # fmt: skip
    return local_workers(jobs or here)
