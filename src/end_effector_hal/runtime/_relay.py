"""Jobs of one program, one at a time: begun by whoever brings them, ended by the program's own thread."""

from __future__ import annotations

import queue
import threading
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from typing import NoReturn

from end_effector_hal.wires import now_us

Rest = Callable[[], None]
"""What a job leaves to the thread of the program, for it may wait or call others."""
Job = Callable[[], Rest | None]


class Relay:
    """Does each job at once in the thread that brings it, if nothing else is to be done; no hand-over is faster.

    A job must not wait. What is left of it is done in the thread that calls `run`, and so is a job that comes while
    another is at work. The order is that in which jobs came. One that fails ends `run` with its error.

    Args:
        due: µs of what the program does by itself, None: nothing.
        done: called after each job with what was left of it, in either thread.
    """

    def __init__(self, due: Callable[[], int | None], done: Callable[[], None]) -> None:
        self._due, self._done = due, done
        self._turn = threading.Lock()
        self._jobs: deque[Job] = deque()
        self._rest: Rest | None = None
        self._begun = False
        self._ended = False
        self._sleeps_until: int | None = None
        self._bell: queue.SimpleQueue[None] = queue.SimpleQueue()
        self.busy_since: int | None = None
        """When what is being done was begun; None: nothing is."""

    def bring(self, job: Job) -> None:
        """Begin it, or leave it to the thread; never waits."""
        self._jobs.append(job)
        # whoever has the turn may have looked for jobs already: then the thread looks again
        if not self._turn.acquire(blocking=False) or self._leaves_something():
            self._bell.put(None)

    def run(self, first: Rest, time_passed: Job) -> None:
        """The program's thread: ``first``, then what is left of jobs, and ``time_passed`` when something is due."""
        with self._turn:
            first()
            self._begun = True
            self._all()
        while not self._ended:
            with suppress(queue.Empty):
                self._bell.get(timeout=self._patience())
            with self._turn:
                self._all()
                due = self._due()
                if due is not None and due <= now_us() and not self._ended:
                    self._whole(time_passed)
                self._sleeps_until = self._due()

    def end(self) -> None:
        """Let `run` return after the jobs that came before."""
        self.bring(lambda: self._end)

    def _end(self) -> None:
        self._ended = True

    def _leaves_something(self) -> bool:
        """With the turn: do what can be done here, and give the turn back; whether the thread is needed."""
        try:
            while self._jobs and self._rest is None and self._begun and not self._ended:
                self.busy_since = now_us()
                self._rest = self._jobs.popleft()()
                if self._rest is None:
                    self._done()
                    self.busy_since = None
            due, until = self._due(), self._sleeps_until
            return self._rest is not None or (due is not None and (until is None or due < until))
        except Exception as error:  # noqa: BLE001 it is the program's, not that of whoever brought a job
            self._rest = _raising(error)
            return True
        finally:
            self._turn.release()

    def _all(self) -> None:
        if self._rest is not None:
            rest, self._rest = self._rest, None
            self._finish(rest)
        while self._jobs and not self._ended:
            self._whole(self._jobs.popleft())

    def _whole(self, job: Job) -> None:
        self.busy_since = now_us()
        self._finish(job())

    def _finish(self, rest: Rest | None) -> None:
        if rest is not None:
            rest()
        self._done()
        self.busy_since = None

    def _patience(self) -> float | None:
        until = self._sleeps_until
        return None if until is None else max(0, until - now_us()) / 1_000_000


def _raising(error: Exception) -> Rest:
    def fail() -> NoReturn:
        raise error

    return fail
