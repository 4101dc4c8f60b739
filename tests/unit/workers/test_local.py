"""Processes of this machine: every item once, whoever dies."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from end_effector_hal.errors import WorkersError
from end_effector_lab.workers import LocalWorkers
from tests.support.patience import wait_until


def add(shared: int, item: int) -> int:
    return shared + item


def who(_: object, __: int) -> int:
    return os.getpid()


def die_at_first(folder: Path, item: int) -> int:
    """The process of item 3 is killed, the first time."""
    if item == 3 and not (folder / "died").exists():
        (folder / "died").touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return item


def die(fatal: int, item: int) -> int:
    if item == fatal:
        os.kill(os.getpid(), signal.SIGKILL)
    return item


def fail(_: object, item: int) -> int:
    raise ValueError(f"no {item}")


@pytest.mark.parametrize("jobs", [1, 2])
def test_every_item_comes_once_with_its_result(jobs: int) -> None:
    with LocalWorkers(jobs) as workers:
        found = list(workers.each(add, 1000, range(100)))
    assert sorted(found) == [(item, item + 1000) for item in range(100)]


def test_one_job_is_done_in_this_process() -> None:
    with LocalWorkers(1) as one, LocalWorkers(2) as two:
        assert {pid for _, pid in one.each(who, None, range(3))} == {os.getpid()}
        assert os.getpid() not in {pid for _, pid in two.each(who, None, range(3))}


def test_few_items_are_taken_before_they_are_needed() -> None:
    taken = []

    def items() -> Iterator[int]:
        for item in range(100):
            taken.append(item)
            yield item

    with LocalWorkers(2) as workers:
        next(workers.each(add, 0, items()))
    assert len(taken) <= 20


def test_the_items_of_a_process_that_was_killed_are_done_again(tmp_path: Path) -> None:
    with LocalWorkers(2) as workers:
        found = [item for item, _ in workers.each(die_at_first, tmp_path, range(40))]
    assert (tmp_path / "died").exists()
    assert sorted(found) == list(range(40))


def test_an_item_that_kills_is_named_after_all_others_are_done() -> None:
    found = []
    with (
        LocalWorkers(2) as workers,
        pytest.raises(WorkersError, match=r"1 item is not done because the workers died: 7\."),
    ):
        found += [item for item, _ in _kept(workers.each(die, 7, range(40)), found)]
    assert sorted(found) == [item for item in range(40) if item != 7]


def _kept(results: Iterator[tuple[int, int]], found: list[int]) -> Iterator[tuple[int, int]]:
    for item, _ in results:
        found.append(item)
    yield from ()


@pytest.mark.parametrize("jobs", [1, 2])
def test_what_a_function_raises_is_raised_here(jobs: int) -> None:
    with LocalWorkers(jobs) as workers, pytest.raises(ValueError, match="no 5"):
        list(workers.each(fail, None, [5]))


def wait_for_file(folder: Path, item: int) -> int:
    (folder / str(os.getpid())).touch()
    signal.pause()
    return item


def test_no_process_is_left_when_its_parent_is_killed(tmp_path: Path) -> None:
    parent = os.fork()
    if parent == 0:
        with LocalWorkers(2) as workers:
            list(workers.each(wait_for_file, tmp_path, range(9)))
        os._exit(1)
    wait_until("both at work", lambda: len(list(tmp_path.iterdir())) == 2, 20)
    os.kill(parent, signal.SIGKILL)
    os.waitpid(parent, 0)
    pids = [int(file.name) for file in tmp_path.iterdir()]
    try:
        wait_until("their end", lambda: not any(Path(f"/proc/{pid}").exists() for pid in pids), 20)
    finally:
        for pid in pids:
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
