"""Work in a copy of the process: its answer comes back, and nothing else of it."""

from __future__ import annotations

import os
import signal
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from end_effector_hal.errors import UsageError
from end_effector_lab.workers import in_a_copy


def test_the_answer_comes_back_and_what_was_changed_there_does_not() -> None:
    here = [1]

    def work() -> tuple[list[int], int]:
        here.append(2)
        return here, os.getpid()

    answer, where = in_a_copy(work)
    assert (answer, here) == ([1, 2], [1])
    assert where != os.getpid()


def test_a_long_answer_comes_whole() -> None:
    assert len(in_a_copy(lambda: "x" * 1_000_000)) == 1_000_000


def test_what_is_raised_there_is_raised_here() -> None:
    def work() -> None:
        raise UsageError("no such tool")

    with pytest.raises(UsageError, match="no such tool"):
        in_a_copy(work)


class TwoWordsError(Exception):
    def __init__(self, one: str, other: str) -> None:
        super().__init__(f"{one} {other}")


def test_what_cannot_be_made_again_is_raised_by_the_work_itself() -> None:
    def work() -> None:
        raise TwoWordsError("no", "tool")

    with pytest.raises(TwoWordsError, match="no tool"):
        in_a_copy(work)


def test_the_work_of_a_copy_that_dies_is_done_here(tmp_path: Path) -> None:
    here = os.getpid()

    def work() -> int:
        (tmp_path / str(os.getpid())).touch()
        if os.getpid() != here:
            os.kill(os.getpid(), signal.SIGKILL)
        return 7

    assert in_a_copy(work) == 7
    assert len(list(tmp_path.iterdir())) == 2


def test_what_comes_from_a_copy_that_fails_does_not_count() -> None:
    here = os.getpid()

    def work() -> int:
        if os.getpid() != here:
            really = os._exit
            os._exit = lambda code: really(3)  # type: ignore[assignment]
        return os.getpid()

    assert in_a_copy(work) == here


def test_a_thread_makes_no_copy() -> None:
    with ThreadPoolExecutor(1) as threads:
        assert threads.submit(in_a_copy, os.getpid).result() == os.getpid()


def test_no_copy_is_left() -> None:
    in_a_copy(lambda: None)
    with pytest.raises(ChildProcessError):
        os.waitpid(-1, os.WNOHANG)
