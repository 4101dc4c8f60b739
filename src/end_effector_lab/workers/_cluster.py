"""The workers of a cluster of dask.distributed."""

from __future__ import annotations

import logging
import pickle
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager, suppress
from itertools import islice
from queue import Empty, SimpleQueue
from typing import Any, Self, TypeVar
from uuid import uuid4

import dask
from distributed import Client, Future, KilledWorker

from end_effector_hal.errors import WorkersError

from ._identity import differences, identity
from ._on_worker import START, SharedPart, do, refusal, unfit
from ._workers import S, not_done

T = TypeVar("T")
R = TypeVar("R")

CONNECT_S = 5.0
JOIN_S = 30.0
"""So long a scheduler may be without a worker at first."""
GONE_S = 60.0
"""So long it may be without one later: they are started again, or more are coming."""
_LOOK_S = 2.0
_TASK_S, _MOST_IN_TASK = 1.0, 64
"""Short items are sent together: about so many seconds of work in one task, so that the scheduler has little to do."""
_TASKS_EACH = 2
"""Tasks for each worker: none waits for the next one."""
_CHECKED = ("python", "distributed", "end-effector-hal")
_FAILURES = (OSError, TimeoutError, CancelledError)
"""The last one: of what was under way when the connection was lost."""


class ClusterWorkers:
    """See `cluster_workers`."""

    def __init__(self, address: str) -> None:
        self._address, self._open = address, ExitStack()

    def __enter__(self) -> Self:
        with ExitStack() as opened:
            opened.enter_context(_quiet())
            opened.enter_context(dask.config.set({"distributed.comm.timeouts.connect": f"{CONNECT_S}s"}))
            try:
                self._client = Client(self._address, timeout=CONNECT_S, set_as_default=False)
            except (*_FAILURES, ValueError, TypeError) as error:
                raise WorkersError(
                    f"The scheduler cannot be reached: {_first_line(error)}.",
                    where=self._address,
                    todo=f"Start it with `dask scheduler`, and workers with {START}.",
                ) from None
            opened.callback(self._close)
            self._check()
            self._open = opened.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self._open.close()

    def _close(self) -> None:
        with suppress(*_FAILURES):
            self._client.close(timeout=CONNECT_S)

    def each(self, function: Callable[[S, T], R], shared: S, items: Iterable[T]) -> Iterator[tuple[T, R]]:
        """See `Workers`."""
        name = f"end-effector-hal-{uuid4().hex}"
        with self._reached():
            self._client.register_plugin(
                SharedPart(name, pickle.dumps((function, shared)), identity()), name=name
            )
        computation = _Computation(self._client, name, items)
        try:
            with self._reached():
                found = self._client.run(refusal, name, on_error="return")
            for worker, why in found.items():
                if why and not isinstance(why, OSError):  # one that has just died is no other one
                    raise unfit(worker, str(why))
            with self._reached():
                yield from computation.results()
        finally:
            with suppress(*_FAILURES):
                computation.cancel()
                self._client.unregister_worker_plugin(name)

    def _check(self) -> None:
        """Raise an error that names the first worker that differs, before anything is sent."""
        with self._reached():
            try:
                self._client.wait_for_workers(1, timeout=JOIN_S)
            except TimeoutError:
                raise WorkersError(
                    f"The scheduler has no worker after {JOIN_S:g} s.",
                    where=self._address,
                    todo=f"Start some with {START}.",
                ) from None
            found = self._client.get_versions(packages=["end-effector-hal"])
        ours = _versions(found["client"])
        for where, theirs in [(self._address, found["scheduler"]), *sorted(found["workers"].items())]:
            if theirs and (why := differences(ours, _versions(theirs))):
                raise unfit(where, why)

    @contextmanager
    def _reached(self) -> Iterator[None]:
        """What goes wrong on the way to the scheduler is one sentence."""
        try:
            yield
        except WorkersError:
            raise
        except _FAILURES as error:
            raise WorkersError(
                f"The scheduler has gone: {_first_line(error)}.",
                where=self._address,
                todo="Finished work is kept: repeat the command when the scheduler runs again.",
            ) from None


class _Computation:
    """Some items of which each is done once, in tasks of several."""

    def __init__(self, client: Client, name: str, items: Iterable[Any]) -> None:
        self._client, self._name, self._items = client, name, iter(items)
        self._again: deque[list[Any]] = deque()
        self._tasks: dict[str, tuple[Future, list[Any]]] = {}
        self._ended: SimpleQueue[Future] = SimpleQueue()
        self._doubtful: list[Any] = []
        self._seconds, self._count = 0.0, 0
        self._looked_at, self._workers, self._seen_at = -_LOOK_S, 0, time.monotonic()

    def results(self) -> Iterator[tuple[Any, Any]]:
        yield from self._until_done()
        lost = []
        for item in self._doubtful:  # alone: what its worker dies of is nothing else
            self._doubtful = []
            self._again.append([item])
            yield from self._until_done()
            lost += self._doubtful
        if lost:
            raise not_done(lost, "because each worker that did it died")

    def cancel(self) -> None:
        """What is not done is not begun any more."""
        if self._tasks and self._client.status == "running":
            self._client.cancel([future for future, _ in self._tasks.values()], force=True)

    def _until_done(self) -> Iterator[tuple[Any, Any]]:
        while True:
            self._look()
            while len(self._tasks) < _TASKS_EACH * max(self._workers, 1) and (items := self._next()):
                self._submit(items)
            if not self._tasks:
                return
            for future, found in self._gathered([*self._some_ended()]):
                items = self._tasks.pop(future.key)[1]
                yield from self._results_of(found, items)

    def _next(self) -> list[Any]:
        if self._again:
            return self._again.popleft()
        each = self._seconds / self._count if self._count else _TASK_S
        return [*islice(self._items, max(1, min(_MOST_IN_TASK, round(_TASK_S / max(each, 1e-6)))))]

    def _submit(self, items: list[Any]) -> None:
        future = self._client.submit(do, self._name, items, key=f"{self._name}-{uuid4().hex}", pure=False)
        self._tasks[future.key] = future, items
        future.add_done_callback(self._ended.put)

    def _some_ended(self) -> Iterator[Future]:
        with suppress(Empty):
            yield self._ended.get(timeout=_LOOK_S)
            while True:
                yield self._ended.get_nowait()

    def _gathered(self, ended: list[Future]) -> Iterator[tuple[Future, Any]]:
        """Each task with what it returned; None: the workers that did it died."""
        with suppress(KilledWorker):
            yield from zip(ended, self._client.gather(ended), strict=True)
            return
        for future in ended:
            try:
                yield future, future.result()
            except KilledWorker:
                yield future, None

    def _results_of(self, found: Any, items: list[Any]) -> Iterator[tuple[Any, Any]]:
        if found is None:
            if len(items) > 1:
                self._again.extend([item] for item in items)
            else:
                self._doubtful += items
            return
        seconds, results = found
        self._seconds, self._count = self._seconds + seconds, self._count + len(items)
        yield from zip(items, results, strict=True)

    def _look(self) -> None:
        """How many workers there are, now and then."""
        now = time.monotonic()
        if self._client.status != "running":
            raise ConnectionError("the connection was closed")
        if now - self._looked_at < _LOOK_S:
            return
        self._workers, self._looked_at = len(self._client.nthreads()), now
        if self._workers:
            self._seen_at = now
        elif now - self._seen_at > GONE_S:
            raise WorkersError(
                f"All workers have gone, {GONE_S:g} s ago.",
                where=self._client.scheduler.address,
                todo="Finished work is kept: repeat the command when there are workers again.",
            )


@contextmanager
def _quiet() -> Iterator[None]:
    """What dask.distributed logs about a lost connection is said in one sentence."""
    logger = logging.getLogger("distributed")
    before = logger.level
    logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        logger.setLevel(before)


def _versions(found: dict[str, Any]) -> dict[str, str]:
    versions = {name: str(found["packages"].get(name) or "") for name in _CHECKED}
    return versions | {"python": ".".join(versions["python"].split(".")[:2])}


def _first_line(error: BaseException) -> str:
    return (str(error).strip().splitlines() or [type(error).__name__])[0].rstrip(".")
