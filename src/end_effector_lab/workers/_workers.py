"""Functions that compute on many items with an executor of `concurrent.futures`.

Rule 1: Each result is yielded once, as soon as it is ready, with its item; the order is the order of completion.
Rule 2: Only a few items are queued for the workers, so that a million items need no memory.
Rule 3: If a worker dies, its items are computed again, one after the other. An item whose workers die repeatedly is
    named by a WorkersError after all others are done.
Rule 4: An exception of the function ends the computation, and is raised to the caller.
"""

from __future__ import annotations

import atexit
import os
import shutil
import signal
import tempfile
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass
from functools import cache
from itertools import islice
from multiprocessing import connection, parent_process
from pathlib import Path
from typing import Any, Self, TypeVar

from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError, WorkersError

S = TypeVar("S")
T = TypeVar("T")
R = TypeVar("R")

LOOK_S = 2.0
"""Time between two checks of the workers while no item is completed, s."""
MOST_IN_TASK, MOST_NAMED = 64, 5
MOST_JOBS, MOST_EACH = 8, 4
"""Maximum number of processes, in all and per processor; the larger limit is valid. Each needs memory."""


class Computation(ABC):
    """Applies one function to many items, in tasks of one or more items.

    Attributes:
        died: exception of a task whose worker died.
        tries: how often an item is then computed again, alone.
        task_s: duration of the work that is sent in one task, s; 0: one item per task.
    """

    died: type[Exception] = BrokenProcessPool
    tries = 3
    task_s = 0.0

    def __init__(self) -> None:
        self._seconds, self._count = 0.0, 0

    @abstractmethod
    def submit(self, items: list[Any]) -> Future[tuple[float, list[Any]]]:
        """Start a task, which returns its duration, s, and the results of its items."""

    @abstractmethod
    def places(self) -> int:
        """Return how many tasks may run or wait at once; raises WorkersError if no worker can be expected."""

    def results(self, items: Iterable[Any]) -> Iterator[tuple[Any, Any]]:
        """Yield each item with its result; raises WorkersError if some were not computed."""
        doubtful: list[Any] = []
        yield from self._until_done(iter(items), doubtful)
        lost = []
        for item in doubtful:  # alone: only this item can be the cause of another death
            for _ in range(self.tries):
                failed: list[Any] = []
                yield from self._until_done(iter([item]), failed)
                if not failed:
                    break
            else:
                lost.append(item)
        if lost:
            names = [str(getattr(item, "id", item)) for item in lost]
            more = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
            raise WorkersError(
                f"{len(names)} {'item is' if len(names) == 1 else 'items are'} not done because the workers died: "
                f"{'; '.join(names[:MOST_NAMED])}{more}.",
                todo="All others are done. Is there memory enough for each process?",
            )

    def _until_done(self, items: Iterator[Any], failed: list[Any]) -> Iterator[tuple[Any, Any]]:
        """Yield each item with its result; add to ``failed`` the items whose worker died."""
        running: dict[Future[tuple[float, list[Any]]], list[Any]] = {}
        while True:
            places = self.places()
            while len(running) < places and (task := [*islice(items, self._size())]):
                running[self.submit(task)] = task
            if not running:
                return
            for future in wait(running, timeout=LOOK_S, return_when=FIRST_COMPLETED).done:
                task = running.pop(future)
                try:
                    seconds, results = future.result()
                except self.died:
                    failed += task
                    continue
                self._seconds, self._count = self._seconds + seconds, self._count + len(task)
                yield from zip(task, results, strict=True)

    def _size(self) -> int:
        each = self._seconds / self._count if self._count else self.task_s
        return max(1, min(MOST_IN_TASK, round(self.task_s / max(each, 1e-6))))


class Workers(ABC):
    """Workers that compute on many items; a context manager, which ends the processes that it has started."""

    def __init__(self) -> None:
        self._open = ExitStack()

    @abstractmethod
    def _begun(
        self, function: Callable[[Any, Any], Any], shared: object
    ) -> AbstractContextManager[Computation]: ...

    def each(self, function: Callable[[S, T], R], shared: S, items: Iterable[T]) -> Iterator[tuple[T, R]]:
        """Yield each item with ``function(shared, item)``.

        Args:
            function: a function of a module, so that other processes find it by its name.
            shared: the same value for all items; a worker receives it once.
            items: the items, read one by one as workers become free.

        Raises:
            WorkersError: a worker does not fit, all workers are gone, or some items could not be computed.
        """
        with self._begun(function, shared) as computation:
            yield from computation.results(items)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._open.close()


def results_of(
    function: Callable[[Any, Any], Any], shared: object, items: Sequence[Any]
) -> tuple[float, list[Any]]:
    """Compute one task in a worker; return its duration, s, and its results."""
    begun = time.perf_counter()
    results = [function(shared, item) for item in items]
    return time.perf_counter() - begun, results


class LocalWorkers(Workers):
    """Workers that are ``jobs`` processes of this machine; with one job, this process computes."""

    def __init__(self, jobs: int) -> None:
        super().__init__()
        self._jobs = jobs

    @contextmanager
    def _begun(self, function: Callable[[Any, Any], Any], shared: object) -> Iterator[Computation]:
        computation = _Processes(self._jobs, function, shared)
        try:
            yield computation
        finally:
            computation.pool.shutdown(cancel_futures=True)

    def each(self, function: Callable[[S, T], R], shared: S, items: Iterable[T]) -> Iterator[tuple[T, R]]:
        if self._jobs == 1:
            yield from ((item, function(shared, item)) for item in items)
        else:
            yield from super().each(function, shared, items)


class _Processes(Computation):
    """Runs tasks in processes of this machine; if one process dies, all end, and the next task starts new ones."""

    def __init__(self, jobs: int, function: Callable[[Any, Any], Any], shared: object) -> None:
        super().__init__()
        self._jobs, self._work = jobs, (function, shared)
        self.pool = self._new_pool()

    def submit(self, items: list[Any]) -> Future[tuple[float, list[Any]]]:
        try:
            return self.pool.submit(_do, items)
        except BrokenProcessPool:
            self.pool = self._new_pool()
            return self.pool.submit(_do, items)

    def places(self) -> int:
        return 4 * self._jobs  # no process waits for its next item

    def _new_pool(self) -> ProcessPoolExecutor:
        return ProcessPoolExecutor(self._jobs, initializer=_begin, initargs=self._work)


_here: dict[str, Any] = {}
"""The function and the shared value of this process."""


def _begin(function: Callable[[Any, Any], Any], shared: object) -> None:
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl-C ends it at once, without a traceback
    threading.Thread(target=_end_with_parent, daemon=True).start()
    _here.update(function=function, shared=shared)


def _end_with_parent() -> None:
    """End this process when its parent is killed, because it would otherwise wait for items forever."""
    if parent := parent_process():
        connection.wait([parent.sentinel])
        os._exit(1)


def _do(items: list[Any]) -> tuple[float, list[Any]]:
    return results_of(_here["function"], _here["shared"], items)


def open_workers(scheduler: str | None, jobs: int | None) -> Workers:
    """Return workers of a scheduler's cluster or of this machine; without ``jobs``, one process per processor.

    Raises:
        UsageError: both arguments are given, or the number of jobs is too large.
        ModuleNotFoundError: dask.distributed, the extra `cluster`, is not installed.
    """
    if scheduler and jobs:
        raise UsageError(
            "--scheduler and --jobs exclude each other.", todo="Leave --jobs out, or --scheduler."
        )
    if scheduler:
        from ._cluster import ClusterWorkers

        return ClusterWorkers(scheduler)
    here = len(os.sched_getaffinity(0))
    most = max(MOST_JOBS, MOST_EACH * here)
    if jobs is not None and jobs > most:
        raise UsageError(
            f"{jobs} processes are too many for this machine.", where="--jobs",
            todo=f"At most {most}; without --jobs it is one for each of its processors.",
        )  # fmt: skip
    return LocalWorkers(jobs or here)


@dataclass(frozen=True)
class ShippedAutomata:
    """The UPPAAL file of a tool, for workers that have another version of the file or none.

    Attributes:
        content: content of the file.
    """

    content: bytes

    @classmethod
    def read(cls, description: Description) -> ShippedAutomata:
        """Read the UPPAAL file of a description; raises OSError."""
        return cls(description.automata_path.read_bytes())

    def of(self, description: Description) -> Description:
        """Return the description with these automata, written to a file on this machine if needed."""
        path = description.automata_path
        if path.is_file() and path.read_bytes() == self.content:
            return description
        return description.with_automata(_written(self.content))


@cache
def _written(content: bytes) -> Path:
    folder = Path(tempfile.mkdtemp(prefix="end-effector-hal-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    file = folder / "end_effector.xml"
    file.write_bytes(content)
    return file
