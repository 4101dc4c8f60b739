"""A program that the line arbiter took for dead, or that does not reach it: it claims nothing that it does not know."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Mapping

import pytest

from end_effector_hal.errors import ArbiterError, LineBusyError
from end_effector_hal.vocabulary import EndEffectorState as State
from end_effector_hal.vocabulary import Evidence
from tests.support.lone_program import BOTTOM, CYLINDER, LINES, OFF, ON, TOP, Tool

pytestmark = pytest.mark.wall


@pytest.fixture
def tool() -> Iterator[Tool]:
    made = Tool()
    made.program.start()
    yield made
    made.arbiter.error = None
    made.program.close()


def overtake(tool: Tool) -> None:
    """The will was executed, all of it, at once."""
    tool.arbiter.active = dict.fromkeys(LINES, OFF)
    tool.arbiter.took_for_dead = True
    tool.confirmed = dict.fromkeys(LINES, OFF)
    tool.program.arbiter_lost(ArbiterError("the lease ended."))


def test_a_will_that_was_executed_ends_the_grip_and_the_program_adopts_what_it_finds(tool: Tool) -> None:
    tool.grip_to(2)
    overtake(tool)
    status = tool.until(lambda status: status.ee == State.STAND_BY)
    assert tool.states() == [State.OFF, State.STAND_BY, State.GRIPPING, State.OFF, State.STAND_BY]
    assert status.reason.startswith("The line arbiter declared this program dead")
    assert status.outputs == (OFF, OFF, OFF)
    assert tool.arbiter.active == dict.fromkeys(LINES, OFF), "nothing is activated by itself (IL-11)"
    tool.grip_to(0)
    assert tool.program.status.reason == ""


def test_while_the_will_runs_the_program_is_off_and_says_why(tool: Tool) -> None:
    tool.grip_to(1)
    tool.arbiter.error = LineBusyError("the last will of hal is being executed.")
    tool.program.arbiter_lost(ArbiterError("the lease ended."))
    status = tool.until(lambda status: status.ee == State.OFF and bool(status.alarm_texts))
    assert "the last will of hal is being executed." in status.alarm_texts
    assert not tool.program.command("grip").accepted
    tool.arbiter.error = None
    overtake(tool)
    assert tool.until(lambda status: status.ee == State.STAND_BY).alarm_texts == ()


def test_lines_that_did_not_move_change_nothing(tool: Tool) -> None:
    tool.grip_to(2)
    tool.program.arbiter_lost(ArbiterError("the line arbiter was lost."))
    tool.confirmed[TOP] = ON
    tool.until(lambda status: status.ee == State.GRIPPED)
    assert State.OFF not in tool.states()[1:]
    assert tool.arbiter.will == ()


def test_a_program_that_was_taken_for_dead_does_not_go_on_with_its_grip(tool: Tool) -> None:
    """Also where its will has left every line as it was: the goal was given up meanwhile."""
    tool.grip_to(1)
    tool.arbiter.took_for_dead = True
    tool.program.arbiter_lost(ArbiterError("the lease ended."))
    status = tool.until(lambda status: status.ee == State.GRIP_ERROR)
    assert tool.states()[-2:] == [State.OFF, State.GRIP_ERROR]
    tool.confirmed[CYLINDER] = ON
    tool.until(lambda status: status.evidence[1] == Evidence.CONFIRMED)
    assert tool.arbiter.active == {BOTTOM: ON, CYLINDER: ON, TOP: OFF}, (
        "nothing is activated by itself (IL-11)"
    )
    assert status.held


def test_what_is_held_is_held_also_by_a_program_that_was_taken_for_dead(tool: Tool) -> None:
    tool.grip_to(2)
    tool.confirmed[TOP] = ON
    tool.until(lambda status: status.ee == State.GRIPPED)
    tool.arbiter.took_for_dead = True
    tool.program.arbiter_lost(ArbiterError("the lease ended."))
    tool.until(lambda status: not tool.arbiter.took_for_dead and not status.alarm_texts)
    assert tool.states()[-1] == State.GRIPPED
    assert State.OFF not in tool.states()[1:]


def test_gripped_is_not_claimed_before_the_arbiter_has_the_will_that_holds(tool: Tool) -> None:
    """Else it might unwind, with the will from before, what is held already."""
    tool.grip_to(2)
    assert tool.arbiter.will
    tool.arbiter.error = ArbiterError("the line arbiter does not answer.")
    tool.confirmed[TOP] = ON
    tool.until(lambda status: any("does not answer" in alarm for alarm in status.alarm_texts))
    for _ in range(30):
        tool.frame()
        threading.Event().wait(0.01)
    assert State.GRIPPED not in tool.states()
    tool.arbiter.error = None
    status = tool.until(lambda status: status.ee == State.GRIPPED)
    assert tool.arbiter.will == ()
    assert status.alarm_texts == ()


def test_what_is_held_stays_held_while_there_is_no_arbiter(tool: Tool) -> None:
    tool.grip_to(2)
    tool.confirmed[TOP] = ON
    tool.until(lambda status: status.ee == State.GRIPPED)
    tool.arbiter.error = ArbiterError("the line arbiter cannot be reached.")
    tool.program.arbiter_lost(ArbiterError("the line arbiter was lost."))
    assert tool.until(lambda status: bool(status.alarm_texts)).held
    tool.arbiter.error = None
    assert tool.until(lambda status: not status.alarm_texts).ee == State.GRIPPED
    assert tool.states()[-1] == State.GRIPPED
    assert State.OFF not in tool.states()[1:]


def test_a_cancel_that_finds_no_arbiter_changes_nothing_and_the_grip_goes_on(tool: Tool) -> None:
    tool.grip_to(1)
    tool.arbiter.error = ArbiterError("the line arbiter cannot be reached.")
    answer = tool.program.command("cancel")
    assert (answer.accepted, answer.decided) == (False, False)
    assert answer.reason.startswith("The line arbiter is lost: nothing was written, and nothing will be.")
    status = tool.until(lambda status: status.arbiter_lost)
    assert status.outputs == (ON, ON, OFF)
    tool.arbiter.error = None
    tool.until(lambda status: not status.alarm_texts)
    assert tool.arbiter.active == {BOTTOM: ON, CYLINDER: ON, TOP: OFF}
    tool.confirmed[CYLINDER] = ON
    tool.until(lambda _: tool.arbiter.active[TOP])


def test_a_drop_whose_first_write_is_lost_is_given_up_and_the_part_stays_held(tool: Tool) -> None:
    """The arbiter has answered just before."""
    tool.grip_to(2)
    tool.confirmed[TOP] = ON
    tool.until(lambda status: status.ee == State.GRIPPED)
    levels = tool.arbiter.levels

    def last_answer() -> Mapping[str, bool]:
        tool.arbiter.levels = levels  # type: ignore[method-assign]
        found = levels()
        tool.arbiter.error = ArbiterError("the line arbiter was lost.")
        return found

    tool.arbiter.levels = last_answer  # type: ignore[method-assign]
    answer = tool.program.command("drop")
    assert (answer.accepted, answer.decided) == (False, False)
    assert answer.reason.startswith("The line arbiter was lost before all of it was written.")
    status = tool.until(lambda status: status.arbiter_lost)
    assert (status.held, status.outputs) == (ON, (ON, ON, ON))
    assert State.RELEASING not in tool.states()
    tool.arbiter.error = None
    tool.until(lambda status: status.ee == State.GRIPPED and not status.alarm_texts)
    assert tool.arbiter.active == dict.fromkeys(LINES, ON)
    assert tool.arbiter.will == ()
    assert tool.program.command("drop").accepted
    tool.confirmed = dict.fromkeys(LINES, OFF)
    tool.until(lambda status: status.ee == State.STAND_BY)


def test_a_frame_that_waited_too_long_proves_nothing(tool: Tool) -> None:
    tool.grip_to(2)
    tool.confirmed[TOP] = ON
    for _ in range(5):
        tool.frame(age_us=200_000)
    assert not tool.program.wait(lambda status: status.ee == State.GRIPPED, 0.3)
    tool.until(lambda status: status.ee == State.GRIPPED)


def test_what_the_arbiter_has_latched_is_an_alarm_until_it_is_reset(tool: Tool) -> None:
    tool.until(lambda status: status.ee == State.STAND_BY)
    tool.program.faults_changed({"e_stop_closed": "IL-13: the emergency stop was opened."})
    tool.until(lambda status: "IL-13: the emergency stop was opened." in status.alarm_texts)
    tool.program.faults_changed({})
    tool.until(lambda status: not status.alarm_texts)
