"""The rules of the serial worker: in virtual time without its thread, and then with it."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator

import pytest

from end_effector_hal.runtime.programs._serial_worker import ANSWER_US, FollowUp, SerialWorker
from end_effector_hal.wires import now_us

PATIENCE_S = 30.0


class Program:
    """A worker with its thread, and what was done where."""

    def __init__(self) -> None:
        self.done: list[tuple[str, bool]] = []
        """What, and whether it was done in the program's own thread."""
        self.due: int | None = None
        self.error: Exception | None = None
        self.begun, self.passed = threading.Event(), threading.Event()
        self.worker = SerialWorker(lambda: self.due, self._time_passed, lambda: None)
        self.thread = threading.Thread(target=self._run)

    def _run(self) -> None:
        try:
            self.worker.run(self.begun.set)
        except Exception as error:  # noqa: BLE001 a test looks at it
            self.error = error

    def _time_passed(self) -> None:
        self.due = None
        self.note("time passed")
        self.passed.set()

    def note(self, what: str) -> None:
        self.done.append((what, threading.current_thread() is self.thread))

    def job(self, what: str, follow_up: FollowUp | None = None) -> Callable[[], FollowUp | None]:
        def do() -> FollowUp | None:
            self.note(what)
            return follow_up

        return do

    def ended(self) -> list[tuple[str, bool]]:
        """Everything that was done, once all is."""
        self.worker.end()
        self.thread.join(PATIENCE_S)
        assert not self.thread.is_alive()
        return self.done


class Steps:
    """A worker without a thread, in virtual time; what was done, in order."""

    def __init__(self) -> None:
        self.now, self.due = 0, None
        self.done: list[str] = []
        self.worker = SerialWorker(
            self._due, self._time_passed, lambda: self.done.append("done"), lambda: self.now
        )

    due: int | None

    def _due(self) -> int | None:
        return self.due

    def _time_passed(self) -> None:
        self.due = None
        self.done.append("time passed")

    def job(self, name: str, *, follows: bool = False) -> Callable[[], FollowUp | None]:
        def do() -> FollowUp | None:
            self.done.append(name)
            return (lambda: self.done.append(f"follow-up of {name}")) if follows else None

        return do

    def begun(self) -> Steps:
        self.worker.begin(lambda: None)
        return self


class TestInVirtualTime:
    def test_rule_1_the_next_job_starts_after_the_follow_up_of_the_one_before(self) -> None:
        steps = Steps().begun()
        steps.worker.submit(steps.job("frame", follows=True))
        steps.worker.submit(steps.job("command"))
        assert steps.done == ["frame"]
        steps.worker.work()
        assert steps.done == ["frame", "follow-up of frame", "done", "command", "done"]

    def test_rule_2_a_job_starts_where_it_is_submitted(self) -> None:
        steps = Steps().begun()
        steps.worker.submit(steps.job("frame"))
        assert steps.done == ["frame", "done"]

    def test_rule_4_jobs_submitted_before_the_beginning_start_after_it(self) -> None:
        steps = Steps()
        steps.worker.submit(steps.job("frame"))
        assert steps.done == []
        steps.worker.begin(lambda: steps.done.append("begun"))
        assert steps.done == ["begun", "frame", "done"]

    def test_rule_4_jobs_submitted_after_the_end_never_start(self) -> None:
        steps = Steps().begun()
        steps.worker.end()
        steps.worker.work()
        steps.worker.submit(steps.job("frame"))
        steps.worker.work()
        assert steps.done == ["done"]

    def test_rule_5_what_is_due_is_done_after_the_jobs_that_were_submitted_before(self) -> None:
        steps = Steps().begun()
        steps.due = 5_000
        steps.now = 4_999
        steps.worker.work()
        assert steps.done == []
        steps.worker.submit(steps.job("frame", follows=True))
        steps.now = 5_000
        steps.worker.work()
        assert steps.done == ["frame", "follow-up of frame", "done", "time passed", "done"]

    def test_rule_6_a_job_that_fails_fails_the_worker(self) -> None:
        steps = Steps().begun()

        def fails() -> None:
            raise RuntimeError("a defect")

        steps.worker.submit(fails)
        with pytest.raises(RuntimeError, match="a defect"):
            steps.worker.work()

    @pytest.mark.parametrize(("late_us", "asked"), [(-1, ["question"]), (0, [])])
    def test_rule_7_a_question_that_could_not_start_in_time_never_starts(
        self, late_us: int, asked: list[str]
    ) -> None:
        steps = Steps().begun()
        steps.worker.submit(steps.job("hangs", follows=True))
        waiting = threading.Thread(
            target=lambda: steps.worker.ask(lambda: (steps.done.append("question"), None))
        )
        waiting.start()
        while len(steps.worker._jobs) < 1:
            threading.Event().wait(0.001)
        steps.now = ANSWER_US + late_us
        steps.worker.work()
        waiting.join(PATIENCE_S)
        assert [each for each in steps.done if each == "question"] == asked

    def test_rule_8_what_is_prepared_waits_for_nothing_and_nothing_waits_for_it(self) -> None:
        pieces: list[str] = []
        began = threading.Event()

        def prepare() -> bool:
            pieces.append("piece")
            if len(pieces) == 3:
                worker.submit(lambda: pieces.append("frame"))
                worker.end()
            return len(pieces) < 100

        worker = SerialWorker(lambda: None, lambda: None, lambda: None, prepare=prepare)
        worker.run(began.set)
        assert began.is_set()
        assert pieces == ["piece", "piece", "piece", "frame"]

    def test_the_worker_is_busy_from_the_job_to_the_end_of_its_follow_up(self) -> None:
        steps = Steps().begun()
        steps.now = 7
        steps.worker.submit(steps.job("frame", follows=True))
        assert steps.worker.busy_since == 7
        steps.worker.work()
        assert steps.worker.busy_since is None


@pytest.fixture
def program() -> Iterator[Program]:
    made = Program()
    made.thread.start()
    assert made.begun.wait(PATIENCE_S)
    while made.worker._turn.locked():
        threading.Event().wait(0.001)
    yield made
    made.ended()


def test_a_job_starts_at_once_in_the_thread_that_submits_it(program: Program) -> None:
    program.worker.submit(program.job("frame"))
    assert program.done == [("frame", False)]


def test_a_follow_up_runs_in_the_thread_of_the_worker(program: Program) -> None:
    program.worker.submit(program.job("frame", lambda: program.note("follow-up")))
    assert program.ended() == [("frame", False), ("follow-up", True)]


def test_a_job_waits_for_the_follow_up_of_the_one_before(program: Program) -> None:
    go = threading.Event()

    def follow_up() -> None:
        assert go.wait(PATIENCE_S)
        program.note("follow-up")

    program.worker.submit(program.job("frame", follow_up))
    program.worker.submit(program.job("command"))
    assert program.done == [("frame", False)]
    go.set()
    assert program.ended() == [("frame", False), ("follow-up", True), ("command", True)]


def test_what_came_before_the_start_is_done_after_it() -> None:
    program = Program()
    program.worker.submit(program.job("early"))
    assert program.done == []
    program.thread.start()
    assert program.ended() == [("early", True)]


def test_jobs_of_many_threads_are_all_done_one_at_a_time_and_each_ones_in_order(program: Program) -> None:
    inside, told = threading.Lock(), dict[int, list[int]]()

    def bring(who: int) -> None:
        for number in range(200):

            def do(number: int = number) -> FollowUp | None:
                assert inside.acquire(blocking=False), "two jobs at a time"
                told.setdefault(who, []).append(number)
                inside.release()
                return (lambda: None) if number % 7 == 0 else None

            program.worker.submit(do)

    threads = [threading.Thread(target=bring, args=(who,)) for who in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(PATIENCE_S)
    program.ended()
    assert program.error is None
    assert told == {who: list(range(200)) for who in range(4)}


def test_what_is_due_is_done_though_no_job_comes_after_the_one_that_made_it_due(program: Program) -> None:
    def makes_due() -> None:
        program.due = now_us() + 1000

    program.worker.submit(makes_due)
    assert program.passed.wait(PATIENCE_S)
    assert program.ended() == [("time passed", True)]


def test_a_job_that_fails_ends_the_program_and_not_the_one_who_submitted_it(program: Program) -> None:
    def fails() -> None:
        raise RuntimeError("a defect")

    program.worker.submit(fails)
    program.worker.submit(program.job("later"))
    program.thread.join(PATIENCE_S)
    assert str(program.error) == "a defect"
    assert program.done == []


def test_no_job_starts_after_one_that_has_failed_in_the_thread_of_the_worker(program: Program) -> None:
    def fails() -> None:
        raise RuntimeError("a defect")

    with program.worker._turn:
        program.worker.submit(fails)
    program.worker._bell.put(None)
    program.thread.join(PATIENCE_S)
    program.worker.submit(program.job("later"))
    assert str(program.error) == "a defect"
    assert program.done == []


def test_what_is_due_is_done_though_nothing_is_ever_submitted() -> None:
    program = Program()
    program.due = now_us() + 20_000
    program.thread.start()
    try:
        assert program.passed.wait(PATIENCE_S)
    finally:
        program.worker.end()
        program.thread.join(PATIENCE_S)
