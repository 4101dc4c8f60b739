"""Call functions at a later time, all in one thread."""

from __future__ import annotations

import heapq
import logging
import threading
from collections.abc import Callable
from itertools import count

from end_effector_hal.wires import now_us

Job = Callable[[], None]
LIMIT = 1000


class Later:
    """Calls jobs when they are due, in order of time. At most ``LIMIT`` jobs wait: a further one is called at once.

    Args:
        log: logs the exceptions of jobs.
    """

    def __init__(self, log: logging.Logger) -> None:
        self._log = log
        self._jobs: list[tuple[int, int, Job]] = []
        self._numbers = count()  # of two jobs that are due at once the first comes first
        self._changed = threading.Condition()
        self._closed = False
        threading.Thread(target=self._run, name="later", daemon=True).start()

    def put(self, due_us: int, job: Job) -> None:
        """Call a job at ``due_us`` (µs, monotonic); if it is due already, or after `close`, call it at once here."""
        with self._changed:
            waits = not self._closed and due_us > now_us() and len(self._jobs) < LIMIT
            if waits:
                heapq.heappush(self._jobs, (due_us, next(self._numbers), job))
                self._changed.notify()
        if not waits:
            job()

    def close(self) -> None:
        """Call all waiting jobs at once; later jobs do not wait any more."""
        with self._changed:
            self._closed, jobs, self._jobs = True, sorted(self._jobs), []
            self._changed.notify()
        for _, _, job in jobs:
            self._call(job)

    def _run(self) -> None:
        while job := self._next():
            self._call(job)

    def _next(self) -> Job | None:
        with self._changed:
            while not self._closed:
                left_us = self._jobs[0][0] - now_us() if self._jobs else None
                if left_us is not None and left_us <= 0:
                    return heapq.heappop(self._jobs)[2]
                self._changed.wait(None if left_us is None else left_us / 1e6)
        return None

    def _call(self, job: Job) -> None:
        try:
            job()
        except Exception:  # noqa: BLE001 a job may raise anything, and the others are due all the same
            self._log.exception("an answer could not be given")
