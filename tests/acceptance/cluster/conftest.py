"""A scheduler and three workers of dask.distributed on loopback ports that the kernel chooses."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from end_effector_lab.processes import Child, Children
from tests.support.patience import wait_until

HERE = Path(__file__).parents[3]
DASK = (sys.executable, "-m", "dask")
ENV = {
    # the first death of a worker with a task reaches the client: what it does then is ours
    "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0",
    "PYTHONPATH": os.pathsep.join([str(HERE / "src"), str(HERE), os.environ.get("PYTHONPATH", "")]),
}


class Cluster:
    """Its processes.

    Attributes:
        address: of the scheduler.
    """

    def __init__(self, children: Children, folder: Path) -> None:
        self._children, self._folder, self._count = children, folder, 0
        file = folder / "scheduler.json"
        self.scheduler = self._start("scheduler", "--port", "0", "--scheduler-file", str(file))
        wait_until("the scheduler's address", lambda: file.exists() and file.read_text().strip())
        self.address = str(json.loads(file.read_text())["address"])

    def worker(self, *options: str) -> Child:
        """Start one; with a nanny, which starts it again when it dies."""
        given = options or ("--nthreads", "1")
        return self._start("worker", self.address, *given, "--local-directory", str(self._folder))

    def _start(self, what: str, *arguments: str) -> Child:
        self._count += 1
        log = self._folder / f"{what}-{self._count}.log"
        host = ("--host", "127.0.0.1", "--no-dashboard")
        return self._children.start(what, [*DASK, what, *arguments, *host], log=log)


@pytest.fixture
def bare(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    """A scheduler without workers."""
    with Children(ENV) as children:
        yield Cluster(children, tmp_path_factory.mktemp("bare"))


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    """A scheduler with three workers."""
    with Children(ENV) as children:
        found = Cluster(children, tmp_path_factory.mktemp("cluster"))
        for _ in range(3):
            found.worker()
        yield found
