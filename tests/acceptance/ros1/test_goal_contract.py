"""Every end of a goal, against the table of docs/reference/actions.md: status, outcome, words, state."""

from __future__ import annotations

import re
import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from end_effector_hal.control import Answer
from tests.support.goals_of_hal_main import GRIP, GRIPPED, GRIPPING, STAND_BY, STATUSES, Hal
from tests.support.patience import wait_until
from tests.support.places import DOCS

pytestmark = pytest.mark.ros
ACTIONS = DOCS / "reference/actions.md"


@pytest.fixture
def hal(monkeypatch: pytest.MonkeyPatch) -> Iterator[Hal]:
    hal = Hal(monkeypatch)
    yield hal
    hal.tool.goes_on.set()
    hal.goals.close()


def begun(hal: Hal) -> None:
    hal.says(state=STAND_BY, count=1)
    hal.send()
    hal.accepted()
    hal.says(state=GRIPPING, command=GRIP)


def gripped(hal: Hal) -> None:
    begun(hal)
    hal.says(state=GRIPPED, count=8)


def cancelled(hal: Hal) -> None:
    begun(hal)
    hal.cancel()
    wait_until("the cancel", lambda: hal.tool.asked == ["grip", "cancel"])
    hal.says(state=STAND_BY, cause=3, count=8, reason="The grip was cancelled.")


def cancelled_too_late(hal: Hal) -> None:
    begun(hal)
    hal.cancel()
    hal.says(state=GRIPPED, count=8)


def failed(hal: Hal) -> None:
    begun(hal)
    hal.says(state=STAND_BY, cause=1, count=8, reason="Cylinder was not confirmed.")


def failed_without_words(hal: Hal) -> None:
    begun(hal)
    hal.says(state=STAND_BY, count=8)


def gone(hal: Hal) -> None:
    begun(hal)
    hal.goals.tick(gone=True)


def started_again(hal: Hal) -> None:
    begun(hal)
    hal.says(state=STAND_BY, begun=6, count=1)


def at_the_end_running(hal: Hal) -> None:
    begun(hal)
    hal.goals.close()


def refused(hal: Hal) -> None:
    hal.tool.replies = [Answer(False, "Nothing is held.")]
    hal.send()


def second(hal: Hal) -> None:
    hal.send("first", "Drop")
    hal.accepted("first")
    hal.send()


def after_the_end(hal: Hal) -> None:
    hal.goals.close()
    hal.send()


def at_the_end_waiting(hal: Hal) -> None:
    hal.tool.goes_on.clear()
    hal.send("first", "LockToolChanger")
    wait_until("the first is asked", lambda: hal.tool.asked)
    hal.send()
    hal.goals.close()


def at_the_end_asked(hal: Hal) -> None:
    hal.tool.goes_on.clear()
    hal.send()
    wait_until("it is asked", lambda: hal.tool.asked)
    hal.goals.close()


def not_reached(hal: Hal) -> None:
    hal.tool.replies = [Answer(False, "The HAL does not answer.", decided=False)]
    hal.send()


def piled_up(hal: Hal) -> None:
    hal.tool.goes_on.clear()
    hal.tool.replies = [Answer(False, "The HAL does not answer.", decided=False)]
    hal.send("first", "Drop")
    wait_until("the first is asked", lambda: hal.tool.asked)
    hal.send()
    hal.tool.goes_on.set()
    hal.end("first", "Drop")


def overtaken(hal: Hal) -> None:
    hal.cancel()
    hal.send()


def cancelled_while_it_waited(hal: Hal) -> None:
    hal.tool.goes_on.clear()
    hal.send("first", "LockToolChanger")
    wait_until("the first is asked", lambda: hal.tool.asked)
    hal.send()
    hal.cancel()
    hal.tool.goes_on.set()


ENDS = [
    (gripped, "SUCCEEDED", "SUCCEEDED"),
    (cancelled_too_late, "SUCCEEDED", "SUCCEEDED"),
    (cancelled, "PREEMPTED", "CANCELLED"),
    (failed, "ABORTED", "FAILED"),
    (failed_without_words, "ABORTED", "FAILED"),
    (gone, "ABORTED", "UNREACHABLE"),
    (started_again, "ABORTED", "UNREACHABLE"),
    (at_the_end_running, "ABORTED", "UNREACHABLE"),
    (refused, "REJECTED", "REJECTED"),
    (second, "REJECTED", "REJECTED"),
    (after_the_end, "REJECTED", "REJECTED"),
    (at_the_end_waiting, "REJECTED", "REJECTED"),
    (at_the_end_asked, "REJECTED", "UNREACHABLE"),
    (not_reached, "REJECTED", "UNREACHABLE"),
    (piled_up, "REJECTED", "UNREACHABLE"),
    (overtaken, "RECALLED", "NOT_EXECUTED"),
    (cancelled_while_it_waited, "RECALLED", "NOT_EXECUTED"),
]


@pytest.mark.parametrize(("how", "status", "outcome"), ENDS, ids=lambda each: getattr(each, "__name__", each))
def test_a_goal_ends_with_the_right_status_outcome_and_words(
    hal: Hal, how: Callable[[Hal], None], status: str, outcome: str
) -> None:
    how(hal)
    assert hal.end() == (status, outcome)
    was_begun = status in ("SUCCEEDED", "PREEMPTED", "ABORTED")
    assert bool(hal.result.steps) == was_begun
    assert (hal.result.seconds > 0.0) == was_begun


def test_the_table_of_the_docs_has_every_end_and_no_other() -> None:
    from end_effector_msgs.msg import Outcome

    rows = re.findall(r"^\| ([A-Z]+) \| (?:`(\w+)` \((\d)\)|no result) \|", ACTIONS.read_text(), re.MULTILINE)
    assert {row[0] for row in rows} == set(STATUSES), "every terminal status of actionlib"
    assert all(getattr(Outcome, name) == int(value) for _, name, value in rows if name)
    pairs = {(status, outcome) for status, outcome, _ in rows if outcome}
    assert pairs == {(status, outcome) for _, status, outcome in ENDS}
    outcomes = {name for name, value in vars(Outcome).items() if name.isupper() and isinstance(value, int)}
    assert {outcome for _, outcome in pairs} == outcomes


def test_who_waited_for_a_hal_that_did_not_answer_is_not_asked_for(hal: Hal) -> None:
    piled_up(hal)
    assert hal.end() == ("REJECTED", "UNREACHABLE")
    assert hal.tool.asked == ["drop"]
    hal.send("later")
    hal.accepted("later")
    assert hal.tool.asked == ["drop", "grip"], "the next goal is"


def test_a_cancel_of_a_goal_that_is_asked_for_reaches_the_tool(hal: Hal) -> None:
    hal.tool.goes_on.clear()
    hal.send()
    wait_until("it is asked", lambda: hal.tool.asked)
    hal.cancel()
    hal.tool.goes_on.set()
    wait_until("the cancel", lambda: hal.tool.asked == ["grip", "cancel"])
    hal.says(state=STAND_BY, cause=3, count=8, reason="The grip was cancelled.")
    assert hal.end() == ("PREEMPTED", "CANCELLED")


def test_a_cancel_of_another_goal_than_a_grip_changes_nothing(hal: Hal) -> None:
    hal.send("drop", "Drop")
    hal.accepted("drop")
    hal.cancel("drop", "Drop")
    hal.says(state=STAND_BY, count=8)
    assert hal.end("drop", "Drop") == ("SUCCEEDED", "SUCCEEDED")
    assert hal.tool.asked == ["drop"]


def test_an_answer_comes_to_an_end_that_has_been_answered(hal: Hal, monkeypatch: pytest.MonkeyPatch) -> None:
    """The tool answers after HALMain has begun to end: the goal has its result, and gets no other."""
    at_the_end_asked(hal)
    assert hal.end() == ("REJECTED", "UNREACHABLE")
    over = threading.Event()
    answer = hal.goals._goals.answer

    def answered(*arguments: Any) -> Any:
        effects = answer(*arguments)
        over.set()
        return effects

    monkeypatch.setattr(hal.goals._goals, "answer", answered)
    hal.tool.goes_on.set()
    assert over.wait(60.0)
    assert hal.end() == ("REJECTED", "UNREACHABLE")
    assert hal.goals._goals.open == ()
