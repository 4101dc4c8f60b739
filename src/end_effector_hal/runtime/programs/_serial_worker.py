"""Run the jobs of one program one at a time, in the order in which they were submitted.

Rule 1: One job at a time. The next one starts when the previous one and its follow-up are done.

Rule 2: A job starts at once, in the thread that submits it, if nothing else is to be done: no hand-over between
threads delays the way from a frame to a line. Otherwise the thread of the worker starts it.

Rule 3: A job does not wait. Code that waits, or calls other components, belongs in the follow-up that a job returns;
the thread of the worker runs it.

Rule 4: Jobs that were submitted before the worker began start after its beginning; jobs that are submitted after its
end never start.

Rule 5: The thread of the worker runs the job for elapsed time, after the jobs that were submitted before.

Rule 6: An exception in a job ends the worker with this error; the submitter does not see the error.

Rule 7: A question that could not start within 2 s never starts: the caller no longer waits.

Rule 8: The worker's thread prepares possible next steps, piece by piece, while it is idle; a job waits for one piece at
most.
"""

from __future__ import annotations

import queue
import threading
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import NoReturn, TypeVar

from end_effector_hal.wires import now_us

FollowUp = Callable[[], None]
"""The part of a job that the thread of the worker runs."""
Job = Callable[[], FollowUp | None]
T = TypeVar("T")
ANSWER_US = 2_000_000
_GRACE_S = 0.5


class SerialWorker:
    """Runs jobs under the rules of this module; `run` is its thread, or `begin` and `work` where a test has no thread.

    Args:
        due: returns the time at which something is due without a job, µs; None: nothing is.
        time_passed: the job that is run then.
        done: called after each job with its follow-up, in either thread.
        clock: returns the time, µs.
        prepare: prepares one piece; returns whether there is more.
    """

    def __init__(
        self,
        due: Callable[[], int | None],
        time_passed: Job,
        done: Callable[[], None],
        clock: Callable[[], int] = now_us,
        prepare: Callable[[], bool] = lambda: False,
    ) -> None:
        self._prepare = prepare
        self._due, self._time_passed, self._done, self._clock = due, time_passed, done, clock
        self._turn = threading.Lock()
        self._jobs: deque[Job] = deque()
        self._follow_up: FollowUp | None = None
        self._begun = False
        self._ended = False
        self._sleeps_until: int | None = None
        self._bell: queue.SimpleQueue[None] = queue.SimpleQueue()
        self.busy_since: int | None = None
        """Time at which the running job began, µs; None: no job runs."""

    def submit(self, job: Job) -> None:
        """Run a job, or leave it to the worker's thread; never waits."""
        self._jobs.append(job)
        # the one who has the turn may have looked for jobs already: then the thread looks again
        if not self._turn.acquire(blocking=False) or self._leaves_work():
            self._bell.put(None)

    def ask(self, question: Callable[[], tuple[T, FollowUp | None]], *, waits: bool = False) -> T | None:
        """Submit a question and return its answer once its follow-up is done; None: no answer came within 2.5 s.

        Args:
            question: returns the answer and the follow-up.
            waits: whether the question itself waits for something, so that the worker's thread must run it.
        """
        answers: queue.SimpleQueue[T] = queue.SimpleQueue()
        until = self._clock() + ANSWER_US

        def job() -> FollowUp | None:
            if self._clock() >= until:
                return None
            answer, follow_up = question()
            if follow_up is None:
                answers.put(answer)
                return None

            def finish() -> None:
                follow_up()
                answers.put(answer)

            return finish

        def whole() -> None:
            if (follow_up := job()) is not None:
                follow_up()

        self.submit((lambda: whole) if waits else job)
        try:
            return answers.get(timeout=ANSWER_US / 1_000_000 + _GRACE_S)
        except queue.Empty:
            return None

    def run(self, first: FollowUp) -> None:
        """Run the worker's thread: begin with ``first``, and return after `end`."""
        self.begin(first)
        while not self._ended:
            while self._bell.empty() and self._patience() != 0 and self._prepares():
                pass
            with suppress(queue.Empty):
                self._bell.get(timeout=self._patience())
            self.work()

    def begin(self, first: FollowUp) -> None:
        """Run ``first``, then all jobs that were submitted before."""
        with self._in_turn():
            first()
            self._begun = True
            self._do_all()
            # it may be that nobody ever submits anything: a link without a byte
            self._sleeps_until = self._due()

    def work(self) -> None:
        """Run all waiting follow-ups and jobs, and the job for elapsed time if it is due; for the worker's thread."""
        with self._in_turn():
            self._do_all()
            due = self._due()
            if due is not None and due <= self._clock() and not self._ended:
                self._do(self._time_passed)
            self._sleeps_until = self._due()

    def end(self) -> None:
        """Make `run` return after the jobs that were submitted before."""
        self.submit(lambda: self._end)

    def _end(self) -> None:
        self._ended = True

    def _prepares(self) -> bool:
        with self._in_turn():
            return not self._jobs and self._prepare()

    @contextmanager
    def _in_turn(self) -> Iterator[None]:
        """Have the turn; after an exception no job starts any more, in whatever thread."""
        with self._turn:
            try:
                yield
            except BaseException:
                self._ended = True
                raise

    def _leaves_work(self) -> bool:
        """Run the jobs that this thread can run, then release the turn; return whether the worker's thread
        is needed.
        """
        try:
            while self._jobs and self._follow_up is None and self._begun and not self._ended:
                self.busy_since = self._clock()
                self._follow_up = self._jobs.popleft()()
                if self._follow_up is None:
                    self._done()
                    self.busy_since = None
            if self._follow_up is not None:
                return True
            due, until = self._due(), self._sleeps_until
            return due is not None and (until is None or due < until)
        except Exception as error:  # noqa: BLE001 it is the program's, not that of the one who submitted a job
            self._follow_up = _raising(error)
            return True
        finally:
            self._turn.release()

    def _do_all(self) -> None:
        if self._follow_up is not None:
            follow_up, self._follow_up = self._follow_up, None
            self._finish(follow_up)
        while self._jobs and not self._ended:
            self._do(self._jobs.popleft())

    def _do(self, job: Job) -> None:
        self.busy_since = self._clock()
        self._finish(job())

    def _finish(self, follow_up: FollowUp | None) -> None:
        if follow_up is not None:
            follow_up()
        self._done()
        self.busy_since = None

    def _patience(self) -> float | None:
        """Return the time until something is due, s; None: nothing is."""
        until = self._sleeps_until
        return None if until is None else max(0, until - self._clock()) / 1_000_000


def _raising(error: Exception) -> FollowUp:
    def fail() -> NoReturn:
        raise error

    return fail
