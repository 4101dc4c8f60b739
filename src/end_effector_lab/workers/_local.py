"""Processes of this machine."""

from __future__ import annotations

import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from itertools import islice
from multiprocessing import connection, parent_process
from typing import Any, Self, TypeVar

from ._workers import S, Workers, not_done

T = TypeVar("T")
R = TypeVar("R")

MOST_DEATHS = 3
"""So often a process may die with an item that was the only one being done."""
_IN_FLIGHT = 4
"""Items for each process: none waits for the next one."""


def local_workers(jobs: int) -> Workers:
    """So many processes of this machine; with one job all is done in this process."""
    return _LocalWorkers(jobs)


class _LocalWorkers:
    def __init__(self, jobs: int) -> None:
        self._jobs = jobs

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def each(self, function: Callable[[S, T], R], shared: S, items: Iterable[T]) -> Iterator[tuple[T, R]]:
        if self._jobs == 1:
            yield from ((item, function(shared, item)) for item in items)
        else:
            yield from _Shift(self._jobs, function, shared, items).results()


class _Shift:
    """One computation: a pool of processes that is replaced when one of them dies.

    Nobody can say which item was to blame. So each item that was being done then is done alone, and only what dies
    alone counts.
    """

    def __init__(
        self, jobs: int, function: Callable[[Any, Any], Any], shared: object, items: Iterable[Any]
    ) -> None:
        self._jobs, self._function, self._shared, self._items = jobs, function, shared, iter(items)
        self._next: deque[Any] = deque()
        self._running: dict[Future[Any], Any] = {}

    def results(self) -> Iterator[tuple[Any, Any]]:
        lost: list[Any] = []
        while True:
            try:
                yield from self._until_a_death(self._jobs, self._jobs * _IN_FLIGHT)
                break
            except BrokenProcessPool:
                doubtful = [*self._running.values()]
                self._running.clear()
            for item in doubtful:
                yield from self._alone(item, lost)
        if lost:
            raise not_done(lost, f"because the process that did it died {MOST_DEATHS} times")

    def _alone(self, item: Any, lost: list[Any]) -> Iterator[tuple[Any, Any]]:
        for _ in range(MOST_DEATHS):
            alone = _Shift(1, self._function, self._shared, [item])
            try:
                yield from alone._until_a_death(1, 1)
                return
            except BrokenProcessPool:
                continue
        lost.append(item)

    def _until_a_death(self, jobs: int, most: int) -> Iterator[tuple[Any, Any]]:
        pool = ProcessPoolExecutor(jobs, initializer=_begin, initargs=(self._function, self._shared))
        try:
            while True:
                self._fill(pool, most)
                if not self._running:
                    return
                done, _ = wait(self._running, return_when=FIRST_COMPLETED)
                for future in done:
                    result = future.result()
                    yield self._running.pop(future), result
        finally:
            pool.shutdown(cancel_futures=True)

    def _fill(self, pool: ProcessPoolExecutor, most: int) -> None:
        self._next.extend(islice(self._items, most - len(self._running) - len(self._next)))
        while self._next:
            self._running[pool.submit(_do, self._next[0])] = self._next[0]
            self._next.popleft()


_here: dict[str, Any] = {}
"""Of a process: what it does, and what is the same for all items."""


def _begin(function: Callable[[Any, Any], Any], shared: object) -> None:
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl-C ends it at once, without a traceback
    threading.Thread(target=_end_with_parent, daemon=True).start()
    _here.update(function=function, shared=shared)


def _end_with_parent() -> None:
    """A process whose parent was killed would wait for items without end."""
    if parent := parent_process():
        connection.wait([parent.sentinel])
        os._exit(1)


def _do(item: Any) -> Any:
    return _here["function"](_here["shared"], item)
