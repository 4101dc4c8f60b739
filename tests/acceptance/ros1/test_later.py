"""Answers that are due later: one thread, in order, all of them at the end."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from functools import partial
from typing import Any

import pytest

from tests.support.patience import wait_until

pytestmark = pytest.mark.ros
LOG = logging.getLogger("tests.later")
AN_HOUR = 3_600_000_000


@pytest.fixture
def later() -> Any:
    from end_effector_hal.ros1._later import Later

    later = Later(LOG)
    yield later
    later.close()


def now() -> int:
    from end_effector_hal.wires import now_us

    return now_us()


def test_what_is_due_is_called_at_once_and_here(later: Any) -> None:
    called: list[int | None] = []
    later.put(now(), lambda: called.append(threading.get_ident()))
    assert called == [threading.get_ident()]


def test_what_is_due_later_is_called_in_order_by_one_thread(later: Any) -> None:
    threads, called = threading.active_count(), []

    def said(word: str) -> Callable[[], None]:
        return lambda: called.append((word, threading.current_thread().name))

    due = now()
    for word, after_us in (("third", 90_000), ("first", 50_000), ("second", 50_001)):
        later.put(due + after_us, said(word))
    assert threading.active_count() == threads
    wait_until("all", lambda: len(called) == 3)
    assert called == [("first", "later"), ("second", "later"), ("third", "later")]


def test_a_job_that_raises_takes_no_other_with_it(later: Any, caplog: pytest.LogCaptureFixture) -> None:
    called: list[str] = []

    def bad() -> None:
        raise ValueError("of a third party")

    later.put(now() + 10_000, bad)
    later.put(now() + 20_000, lambda: called.append("the next"))
    wait_until("the next", lambda: called)
    assert "an answer could not be given" in caplog.text


def test_at_the_end_all_that_waits_is_called_in_order(later: Any) -> None:
    called: list[int] = []
    for number in (3, 1, 2):
        later.put(now() + number * AN_HOUR, partial(called.append, number))
    later.close()
    assert called == [1, 2, 3]
    later.put(now() + AN_HOUR, lambda: called.append(4))
    assert called == [1, 2, 3, 4], "nothing waits after the end"


def test_a_bounded_number_waits(later: Any) -> None:
    from end_effector_hal.ros1._later import LIMIT

    called: list[int] = []
    for number in range(LIMIT + 1):
        later.put(now() + AN_HOUR, partial(called.append, number))
    assert called == [LIMIT]
