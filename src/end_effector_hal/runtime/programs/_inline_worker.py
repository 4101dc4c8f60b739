"""Run the jobs of a program in the thread that submits them, for virtual time."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import TypeVar

from ._serial_worker import FollowUp, Job

T = TypeVar("T")


class InlineWorker:
    """Runs jobs as `SerialWorker` does, without a thread: a job and its follow-up are done before `submit` returns.

    A job that is submitted from within another job runs right after it.

    Args:
        due: returns the time at which something is due without a job, µs; None: nothing is.
        time_passed: the job that is run then.
        done: called after each job.
        clock: returns the time, µs.
        prepare: not used, because in virtual time no reaction is late.
    """

    def __init__(
        self,
        due: Callable[[], int | None],
        time_passed: Job,
        done: Callable[[], None],
        clock: Callable[[], int],
        prepare: Callable[[], bool] = lambda: False,
    ) -> None:
        self._due, self._time_passed, self._done, self._clock = due, time_passed, done, clock
        self._jobs: deque[Job] = deque()
        self._busy = self._begun = self._ended = False
        self.busy_since: int | None = None
        """Always None: no job takes any time."""

    def submit(self, job: Job) -> None:
        """Run a job now, or right after the running one."""
        if not self._ended:
            self._jobs.append(job)
            self._do_all()

    def ask(self, question: Callable[[], tuple[T, FollowUp | None]], *, waits: bool = False) -> T | None:
        """Return the answer to a question once its follow-up is done; None: there is no answer."""
        answers: list[T] = []

        def job() -> FollowUp | None:
            answer, follow_up = question()
            answers.append(answer)
            return follow_up

        self.submit(job)
        return answers[0] if answers else None

    def run(self, first: FollowUp) -> None:
        """Raise NotImplementedError: this worker has no thread."""
        raise NotImplementedError("a program in virtual time is begun, not started")

    def begin(self, first: FollowUp) -> None:
        """Run ``first``, then all jobs that were submitted before."""
        self._begun = True
        self._jobs.appendleft(lambda: first)
        self._do_all()

    def work(self) -> None:
        """Run the job for elapsed time if it is due."""
        due = self._due()
        if due is not None and due <= self._clock():
            self.submit(self._time_passed)

    def end(self) -> None:
        """Run no further jobs."""
        self._ended = True

    def _do_all(self) -> None:
        if self._busy or not self._begun:
            return
        self._busy = True
        try:
            while self._jobs and not self._ended:
                if (follow_up := self._jobs.popleft()()) is not None:
                    follow_up()
                self._done()
        finally:
            self._busy = False
