"""Jobs of a program: begun by whoever brings them, ended by its own thread, one at a time and in order."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator

import pytest

from end_effector_hal.runtime._relay import Relay, Rest
from end_effector_hal.wires import now_us

PATIENCE_S = 30.0


class Program:
    """A relay with its thread, and what was done where."""

    def __init__(self) -> None:
        self.done: list[tuple[str, bool]] = []
        """What, and whether it was done in the program's own thread."""
        self.due: int | None = None
        self.error: Exception | None = None
        self.begun, self.passed = threading.Event(), threading.Event()
        self.relay = Relay(lambda: self.due, lambda: None)
        self.thread = threading.Thread(target=self._run)

    def _run(self) -> None:
        try:
            self.relay.run(self.begun.set, self._time_passed)
        except Exception as error:  # noqa: BLE001 a test looks at it
            self.error = error

    def _time_passed(self) -> None:
        self.due = None
        self.note("time passed")
        self.passed.set()

    def note(self, what: str) -> None:
        self.done.append((what, threading.current_thread() is self.thread))

    def job(self, what: str, rest: Rest | None = None) -> Callable[[], Rest | None]:
        def do() -> Rest | None:
            self.note(what)
            return rest

        return do

    def ended(self) -> list[tuple[str, bool]]:
        """Everything that was done, once all is."""
        self.relay.end()
        self.thread.join(PATIENCE_S)
        assert not self.thread.is_alive()
        return self.done


@pytest.fixture
def program() -> Iterator[Program]:
    made = Program()
    made.thread.start()
    assert made.begun.wait(PATIENCE_S)
    while made.relay._turn.locked():
        threading.Event().wait(0.001)
    yield made
    made.ended()


def test_a_job_is_done_at_once_by_whoever_brings_it(program: Program) -> None:
    program.relay.bring(program.job("frame"))
    assert program.done == [("frame", False)]


def test_what_is_left_of_a_job_is_done_in_the_programs_own_thread(program: Program) -> None:
    program.relay.bring(program.job("frame", lambda: program.note("rest")))
    assert program.ended() == [("frame", False), ("rest", True)]


def test_what_comes_while_something_is_left_to_be_done_waits_for_it(program: Program) -> None:
    go = threading.Event()

    def rest() -> None:
        assert go.wait(PATIENCE_S)
        program.note("rest")

    program.relay.bring(program.job("frame", rest))
    program.relay.bring(program.job("command"))
    assert program.done == [("frame", False)]
    go.set()
    assert program.ended() == [("frame", False), ("rest", True), ("command", True)]


def test_what_came_before_the_start_is_done_after_it() -> None:
    program = Program()
    program.relay.bring(program.job("early"))
    assert program.done == []
    program.thread.start()
    assert program.ended() == [("early", True)]


def test_jobs_of_many_threads_are_all_done_one_at_a_time_and_each_ones_in_order(program: Program) -> None:
    inside, told = threading.Lock(), dict[int, list[int]]()

    def bring(who: int) -> None:
        for number in range(200):

            def do(number: int = number) -> Rest | None:
                assert inside.acquire(blocking=False), "two jobs at a time"
                told.setdefault(who, []).append(number)
                inside.release()
                return (lambda: None) if number % 7 == 0 else None

            program.relay.bring(do)

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

    program.relay.bring(makes_due)
    assert program.passed.wait(PATIENCE_S)
    assert program.ended() == [("time passed", True)]


def test_a_job_that_fails_ends_the_program_and_not_who_brought_it(program: Program) -> None:
    def fails() -> None:
        raise RuntimeError("a defect")

    program.relay.bring(fails)
    program.relay.bring(program.job("later"))
    program.thread.join(PATIENCE_S)
    assert str(program.error) == "a defect"
    assert program.done == []
