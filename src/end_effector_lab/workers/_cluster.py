"""Workers of a cluster, used through the executor of dask.distributed."""

from __future__ import annotations

import asyncio
import logging
import pickle
import platform
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError, Future
from contextlib import ExitStack, contextmanager, suppress
from functools import cache
from typing import Any, Self
from uuid import uuid4

import dask
from distributed import Client, KilledWorker, Worker, WorkerPlugin, get_worker

from end_effector_hal.errors import WorkersError
from end_effector_hal.recording import product_version
from end_effector_lab.results import source_checksum

from ._workers import LOOK_S, Computation, Workers, results_of

CONNECT_S = 5.0
JOIN_S = 30.0
"""Longest time to wait for the first worker, s."""
GONE_S = 60.0
"""Longest time without any worker later, s: workers may be restarted, or more may be coming."""
_START = "`dask worker ADDRESS --nworkers N --nthreads 1`"
_CHECKED = ("python", "distributed", "end-effector-hal")
_FAILURES = (OSError, TimeoutError, CancelledError)
"""Errors of a lost connection; a task that was running at its loss raises CancelledError."""


@cache
def identity() -> dict[str, str]:
    """Return the versions that must be equal on both sides: two versions of a program would mix their results."""
    return {
        "Python": ".".join(platform.python_version_tuple()[:2]),
        "end-effector-hal": product_version(),
        "the source of end-effector-hal": source_checksum(),
    }


class _SharedPart(WorkerPlugin):  # type: ignore[misc]
    """The function and the shared value; dask sends both once to each worker, also to one that joins later."""

    def __init__(self, name: str, content: bytes, ours: dict[str, str]) -> None:
        self.name, self._content, self._ours = name, content, ours
        self._read: Any = None

    def setup(self, worker: Worker) -> None:
        self.refusal = _differences(self._ours, identity())
        if not self.refusal and worker.state.nthreads != 1:
            self.refusal = f"it has {worker.state.nthreads} threads, which would wait for each other"

    def read(self) -> tuple[Any, Any]:
        """Return the function and the shared value; raises WorkersError if this worker does not fit."""
        where = get_worker().address
        if self.refusal:
            raise _unfit(where, self.refusal)
        try:
            if self._read is None:
                # anyone who reaches a worker can run programs there anyway
                self._read = pickle.loads(self._content)
        except (ImportError, AttributeError, pickle.UnpicklingError) as error:
            raise _unfit(where, f"it cannot read what it was sent ({error})") from None
        return self._read  # type: ignore[no-any-return]


def _refusal(name: str, dask_worker: Worker) -> str:
    plugin = dask_worker.plugins.get(name)
    return plugin.refusal if isinstance(plugin, _SharedPart) else ""


def _do(name: str, items: Sequence[Any]) -> tuple[float, list[Any]]:
    plugin = get_worker().plugins[name]
    assert isinstance(plugin, _SharedPart)
    return results_of(*plugin.read(), items)


class ClusterWorkers(Workers):
    """The workers of a cluster.

    Entering the context raises WorkersError if the scheduler cannot be reached or has no worker, or if a worker does
    not fit.

    Args:
        address: address of the scheduler, such as ``tcp://10.0.0.1:8786``.
    """

    def __init__(self, address: str) -> None:
        super().__init__()
        self._address = address

    def __enter__(self) -> Self:
        with ExitStack() as opened:
            opened.enter_context(_no_log_of_dask())
            opened.enter_context(dask.config.set({"distributed.comm.timeouts.connect": f"{CONNECT_S}s"}))
            try:
                self._client = Client(self._address, timeout=CONNECT_S, set_as_default=False)
            except (*_FAILURES, ValueError, TypeError) as error:
                raise WorkersError(
                    f"The scheduler cannot be reached: {_first_line(error)}.",
                    where=self._address,
                    todo=f"Start it with `dask scheduler`, and workers with {_START}.",
                ) from None
            opened.callback(self._close)
            self._check()
            self._open = opened.pop_all()
        return self

    def _close(self) -> None:
        with suppress(*_FAILURES):
            self._client.close(timeout=CONNECT_S)

    @contextmanager
    def _begun(self, function: Callable[[Any, Any], Any], shared: object) -> Iterator[Computation]:
        name = f"end-effector-hal-{uuid4().hex}"
        part = _SharedPart(name, pickle.dumps((function, shared)), identity())
        tasks = _Tasks(self._client, name)
        try:
            with self._reached():
                self._client.register_plugin(part, name=name)
                found = self._client.run(_refusal, name, on_error="return")
            for worker, why in found.items():
                if why and not isinstance(why, OSError):  # a worker that has just died is no misfit
                    raise _unfit(worker, str(why))
            with self._reached():
                yield tasks
        finally:
            with suppress(*_FAILURES):
                if self._client.status == "running":
                    tasks.cancel()
                    self._client.unregister_worker_plugin(name)

    def _check(self) -> None:
        """Raise an error that names the first machine with other versions, before any item is sent."""
        with self._reached():
            try:
                self._client.wait_for_workers(1, timeout=JOIN_S)
            except TimeoutError:
                raise WorkersError(
                    f"The scheduler has no worker after {JOIN_S:g} s.",
                    where=self._address,
                    todo=f"Start some with {_START}.",
                ) from None
            found = self._client.get_versions(packages=["end-effector-hal"])
        ours = _versions(found["client"])
        for where, theirs in [(self._address, found["scheduler"]), *sorted(found["workers"].items())]:
            if theirs and (why := _differences(ours, _versions(theirs))):
                raise _unfit(where, why)

    @contextmanager
    def _reached(self) -> Iterator[None]:
        """Convert a lost connection to the scheduler into a WorkersError of one sentence."""
        try:
            yield
        except WorkersError:
            raise
        except _FAILURES as error:
            raise WorkersError(
                f"The scheduler has gone: {_first_line(error)}.",
                where=self._address,
                todo="Repeat the command with a new folder when the scheduler runs again.",
            ) from None


class _Tasks(Computation):
    died = KilledWorker
    tries = 1  # dask has tried it `allowed-failures` times already
    task_s = 1.0  # short items together, so that the scheduler has little to do

    def __init__(self, client: Client, name: str) -> None:
        super().__init__()
        self._client, self._name = client, name
        self._under_way: set[Any] = set()
        self._looked_at, self._workers, self._seen_at = -LOOK_S, 0, time.monotonic()

    def submit(self, items: list[Any]) -> Future[tuple[float, list[Any]]]:
        task, answer = (
            self._client.submit(_do, self._name, items, pure=False),
            Future[tuple[float, list[Any]]](),
        )
        self._under_way.add(task)
        self._client.loop.add_callback(self._answer, task, answer)
        return answer

    async def _answer(self, task: Any, answer: Future[tuple[float, list[Any]]]) -> None:
        """Pass on how a task has ended.

        dask's own executor asks for the status after the result: if the worker has died between, it takes the result
        for an error (ValueError).
        """
        try:
            answer.set_result(await task)
        except asyncio.CancelledError as error:
            answer.set_exception(CancelledError(str(error)))
        except Exception as error:  # noqa: BLE001 -- whatever the function raises is raised by the result
            answer.set_exception(error)
        finally:
            self._under_way.discard(task)

    def cancel(self) -> None:
        """Cancel all tasks that have not ended."""
        self._client.cancel(list(self._under_way.copy()))

    def places(self) -> int:
        now = time.monotonic()
        if self._client.status != "running":
            raise ConnectionError("the connection was closed")
        if now - self._looked_at >= LOOK_S:
            self._workers, self._looked_at = len(self._client.nthreads()), now
        if self._workers:
            self._seen_at = now
        elif now - self._seen_at > GONE_S:
            raise WorkersError(
                f"All workers have gone, {GONE_S:g} s ago.",
                where=self._client.scheduler.address,
                todo="Repeat the command with a new folder when there are workers again.",
            )
        return 2 * max(self._workers, 1)  # no worker waits for its next task


@contextmanager
def _no_log_of_dask() -> Iterator[None]:
    """Silence what dask.distributed logs about a lost connection: the command reports it in one sentence."""
    logger = logging.getLogger("distributed")
    before = logger.level
    logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        logger.setLevel(before)


def _unfit(worker: str, why: str) -> WorkersError:
    return WorkersError(
        f"This worker does not fit: {why}.",
        where=worker,
        todo=f"Install the same versions there, and start it with {_START}.",
    )


def _differences(ours: dict[str, str], theirs: dict[str, str]) -> str:
    return "; ".join(
        f"{name} is {theirs.get(name) or 'missing'} there, {value or 'missing'} here"
        for name, value in ours.items()
        if theirs.get(name) != value
    )


def _versions(found: dict[str, Any]) -> dict[str, str]:
    versions = {name: str(found["packages"].get(name) or "") for name in _CHECKED}
    return versions | {"python": ".".join(versions["python"].split(".")[:2])}


def _first_line(error: BaseException) -> str:
    return (str(error).strip().splitlines() or [type(error).__name__])[0].rstrip(".")
