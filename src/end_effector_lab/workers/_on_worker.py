"""What stands on a worker of dask.distributed: the function, and what is the same for all items."""

from __future__ import annotations

import pickle
import time
from collections.abc import Sequence
from typing import Any

from distributed import Worker, WorkerPlugin, get_worker

from end_effector_hal.errors import WorkersError

from ._identity import differences, identity

START = "`dask worker ADDRESS --nworkers N --nthreads 1`"


class SharedPart(WorkerPlugin):  # type: ignore[misc]
    """Sent once to each worker, also to one that joins later.

    Args:
        name: of the computation.
        content: the function and what is shared, pickled.
        ours: the `identity` of who sends it.
    """

    def __init__(self, name: str, content: bytes, ours: dict[str, str]) -> None:
        self.name, self._content, self._ours = name, content, ours
        self._read: Any = None

    def setup(self, worker: Worker) -> None:
        """Say why this worker does not fit; empty: it does."""
        self.refusal = differences(self._ours, identity())
        if not self.refusal and worker.state.nthreads != 1:
            self.refusal = f"it has {worker.state.nthreads} threads, which would wait for each other"

    def read(self) -> tuple[Any, Any]:
        """The function, and what is shared."""
        if self._read is None:
            self._read = pickle.loads(self._content)  # who may reach a worker may run programs there anyway
        return self._read  # type: ignore[no-any-return]


def refusal(name: str, dask_worker: Worker) -> str:
    """Why this worker does not fit; empty: it does."""
    plugin = dask_worker.plugins.get(name)
    return plugin.refusal if isinstance(plugin, SharedPart) else ""


def do(name: str, items: Sequence[Any]) -> tuple[float, list[Any]]:
    """The results of some items, and the seconds that they took.

    Raises:
        WorkersError: this worker does not fit.
    """
    worker = get_worker()
    plugin = worker.plugins[name]
    assert isinstance(plugin, SharedPart)
    if plugin.refusal:
        raise unfit(worker.address, plugin.refusal)
    try:
        function, shared = plugin.read()
    except (ImportError, AttributeError, pickle.UnpicklingError) as error:
        raise unfit(worker.address, f"it cannot read what it was sent ({error})") from None
    begun = time.perf_counter()
    results = [function(shared, item) for item in items]
    return time.perf_counter() - begun, results


def unfit(worker: str, why: str) -> WorkersError:
    """The error of a worker that does not fit."""
    return WorkersError(
        f"This worker does not fit: {why}.",
        where=worker,
        todo=f"Install the same versions there, and start it with {START}.",
    )
