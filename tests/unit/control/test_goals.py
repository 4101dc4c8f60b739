"""The rules of goals, one after the other, in virtual time and without a program."""

from __future__ import annotations

from typing import Any

import pytest

from end_effector_hal.control import Answer, Status, unknown_now
from end_effector_hal.control.goals import (
    NOT_BEGUN,
    REACHED,
    Effect,
    Goal,
    GoalEffect,
    Goals,
    Outcome,
    Phase,
    judge,
    reset_answer,
)
from end_effector_hal.control.goals._goals import ANSWER_US
from end_effector_hal.vocabulary import (
    ARBITER_LOST,
    Alarm,
    Cause,
    ChangerState,
    Command,
    Evidence,
)
from end_effector_hal.vocabulary import EndEffectorState as State

YES = Answer(True, count=7)
NO = Answer(False, "Nothing is held.")
SILENT = Answer(False, "The program does not answer.", decided=False)


def status(**fields: Any) -> Status:
    told = {
        "at": 0,
        "ee": State.STAND_BY,
        "command": Command.NONE,
        "actuators": (),
        "outputs": (),
        "evidence": (),
    }
    return Status(**(told | fields))


class Room:
    """The goals of a tool, and what was to be done."""

    def __init__(self) -> None:
        self.goals: Goals[Goal] = Goals("The program")
        self.at = 1_000_000
        self.done: list[tuple[Effect, str]] = []

    def do(self, effects: list[GoalEffect[Goal]]) -> None:
        self.done += [(todo, goal.name) for todo, goal in effects]

    def come(self, command: Command = Command.GRIP, name: str = "a") -> Goal:
        goal = Goal(command, name)
        self.do(self.goals.begin(goal, self.at))
        return goal

    def answer(self, goal: Goal, answer: Answer = YES) -> None:
        self.do(self.goals.answer(goal, answer, self.at))

    def target(self, command: Command, answer: Answer) -> Goal:
        """A position that is asked for, with its answer."""
        goal = Goal(command, "gripper_cmd", is_target=True)
        self.do(self.goals.begin(goal, self.at))
        self.answer(goal, answer)
        return goal

    def see(self, count: int = 8, session: int = 5, **fields: Any) -> None:
        self.do(self.goals.see(status(begun=session, count=count, **fields), self.at))

    def begun(self, command: Command = Command.GRIP, name: str = "a") -> Goal:
        goal = self.come(command, name)
        self.answer(goal)
        self.done.clear()
        return goal


@pytest.fixture
def room() -> Room:
    return Room()


def end(goal: Goal) -> tuple[Outcome, str]:
    assert goal.phase is Phase.ENDED
    return goal.ending.outcome, goal.ending.reason


def test_rule_1_goals_are_decided_in_the_order_in_which_they_came(room: Room) -> None:
    first, second = room.come(Command.LOCK, "first"), room.come(Command.RELEASE, "second")
    assert room.done == [(Effect.ASK, "first")]
    assert second.phase is Phase.WAITING
    room.answer(first, NO)
    assert room.done[1:] == [(Effect.REPORT_END, "first"), (Effect.ASK, "second")]


def test_rule_2_a_second_goal_is_refused_and_the_first_goes_on(room: Room) -> None:
    first = room.come(Command.RELEASE, "first")
    waiting = room.come(name="waiting")
    room.answer(first)
    late = room.come(name="late")
    for goal in (waiting, late):
        assert end(goal) == (
            Outcome.REJECTED,
            "first is still running: one goal at a time. Wait for its end.",
        )
    assert first.phase is Phase.RUNNING
    room.see(ee=State.STAND_BY)
    assert end(first) == (Outcome.SUCCEEDED, "")


def test_rule_3_a_program_refuses_in_its_own_words(room: Room) -> None:
    goal = room.come()
    room.answer(goal, NO)
    assert end(goal) == (Outcome.REJECTED, "Nothing is held.")
    assert goal.ending.seconds is None, "it was not begun"


PROVEN = {
    Command.GRIP: {"ee": State.GRIPPED, "evidence": (Evidence.CONFIRMED, Evidence.CONFIRMED), "outputs": (True, True)},
    Command.RELEASE: {"ee": State.STAND_BY, "evidence": (Evidence.GONE, Evidence.GONE), "outputs": (False, False)},
}  # fmt: skip


@pytest.mark.parametrize("command", PROVEN)
def test_rule_8_a_position_that_the_sensors_prove_is_reached_at_once(room: Room, command: Command) -> None:
    room.see(**PROVEN[command])
    goal = room.target(command, NO)
    assert end(goal) == (Outcome.SUCCEEDED, REACHED)
    other = room.come(command)
    room.answer(other, NO)
    assert end(other) == (Outcome.REJECTED, NO.reason), "it asks for a grip or a drop, not for a position"


@pytest.mark.parametrize("level", [Evidence.GONE, Evidence.UNKNOWN])
def test_rule_8_what_does_not_grip_the_part_counts_only_for_a_release(room: Room, level: Evidence) -> None:
    room.see(ee=State.GRIPPED, evidence=(level, Evidence.CONFIRMED), outputs=(False, True))
    goal = room.target(Command.GRIP, NO)
    assert end(goal) == (Outcome.SUCCEEDED, REACHED)


@pytest.mark.parametrize("command", PROVEN)
@pytest.mark.parametrize(
    "unlike",
    [
        {"evidence": (Evidence.CONFIRMED, Evidence.UNKNOWN)},
        {"evidence": (Evidence.UNKNOWN, Evidence.GONE)},
        {"ee": State.GRIP_ERROR},
        {"command": Command.LOCK},
    ],
    ids=str,
)
def test_rule_8_and_any_other_one_is_not(room: Room, command: Command, unlike: dict[str, Any]) -> None:
    room.see(**PROVEN[command] | unlike)
    goal = room.target(command, NO)
    assert end(goal) == (Outcome.REJECTED, NO.reason)


def test_rule_8_who_does_not_answer_proves_nothing(room: Room) -> None:
    room.see(**PROVEN[Command.RELEASE])
    goal = room.target(Command.RELEASE, SILENT)
    assert end(goal) == (Outcome.UNREACHABLE, SILENT.reason)


def test_rule_3_who_waited_while_the_program_did_not_answer_gets_the_same_answer(room: Room) -> None:
    first, lock, drop = room.come(), room.come(Command.LOCK, "lock"), room.come(Command.RELEASE, "drop")
    given_up = room.come(name="given up")
    room.do(room.goals.cancel(given_up))
    room.answer(first, SILENT)
    assert end(first) == end(lock) == end(drop) == (Outcome.UNREACHABLE, SILENT.reason)
    assert end(given_up) == (Outcome.NOT_EXECUTED, NOT_BEGUN)


def test_rule_3_no_answer_in_time_and_one_that_comes_later_changes_nothing(room: Room) -> None:
    goal = room.come()
    room.at += ANSWER_US
    room.do(room.goals.tick(room.at))
    assert goal.phase is Phase.ASKED
    room.do(room.goals.tick(room.at + 1))
    assert end(goal) == (Outcome.UNREACHABLE, "The program does not answer.")
    assert room.done[1:] == [(Effect.GIVE_UP, "a"), (Effect.REPORT_END, "a")]
    room.answer(goal)
    assert end(goal)[0] is Outcome.UNREACHABLE
    assert room.goals.open == ()


def test_rule_4_only_statuses_that_follow_the_acceptance_count(room: Room) -> None:
    room.see(count=6, ee=State.GRIPPED)
    goal = room.begun()
    room.see(count=6, ee=State.GRIPPED)
    assert room.done == []
    room.see(count=7, ee=State.GRIPPING, command=Command.GRIP)
    assert room.done == [(Effect.REPORT_PROGRESS, "a")]
    room.at += 2_500_000
    room.see(count=8, ee=State.GRIPPED)
    assert room.done[1:] == [(Effect.REPORT_PROGRESS, "a"), (Effect.REPORT_END, "a")]
    assert goal.ending.seconds == 2.5


LOST = (Alarm(ARBITER_LOST, "", {"why": "it is away"}),)


def test_rule_4_an_end_that_was_seen_before_the_answer_counts(room: Room) -> None:
    goal = room.come()
    room.see(ee=State.GRIPPED)
    room.answer(goal)
    assert end(goal) == (Outcome.SUCCEEDED, "")


@pytest.mark.parametrize(
    ("command", "fields", "outcome", "reason"),
    [
        (Command.GRIP, {"ee": State.GRIPPED}, "SUCCEEDED", ""),
        (Command.GRIP, {"cause": Cause.CANCELLED, "reason": "cancelled"}, "CANCELLED", "cancelled"),
        (Command.GRIP, {"cause": Cause.TIMED_OUT, "reason": "not confirmed"}, "FAILED", "not confirmed"),
        (Command.GRIP, {"ee": State.RELEASE_ERROR, "reason": "still there"}, "FAILED", "still there"),
        (Command.GRIP, {}, "FAILED", "The end-effector is STAND_BY."),
        (Command.RELEASE, {}, "SUCCEEDED", ""),
        (Command.RELEASE, {"ee": State.RELEASE_ERROR, "reason": "still there"}, "FAILED", "still there"),
        (Command.RELEASE, {"cause": Cause.CANCELLED, "reason": "old"}, "SUCCEEDED", ""),
        (Command.LOCK, {"changer": ChangerState.LOCKED}, "SUCCEEDED", ""),
        (Command.UNLOCK, {"changer": ChangerState.UNLOCKED}, "SUCCEEDED", ""),
        (
            Command.UNLOCK,
            {"changer": ChangerState.LOCKING, "reason": "old", "changer_reason": "why"},
            "FAILED",
            "The tool changer is LOCKING: its sensors do not prove UNLOCKED. why",
        ),
        (Command.RELEASE, {"ee": State.OFF, "reason": "why", "alarms": LOST}, "UNREACHABLE", "why"),
        (Command.RELEASE, {"ee": State.RELEASE_ERROR, "reason": "why", "alarms": LOST}, "UNREACHABLE", "why"),
        (Command.RELEASE, {"alarms": LOST}, "SUCCEEDED", ""),
        (
            Command.LOCK,
            {"changer": ChangerState.UNKNOWN, "reason": "old", "changer_reason": "why", "alarms": LOST},
            "UNREACHABLE",
            "why",
        ),
        (Command.LOCK, {"changer": ChangerState.LOCKED, "alarms": LOST}, "SUCCEEDED", ""),
    ],
)
def test_rule_4_the_outcome_is_read_from_the_status(
    command: Command, fields: dict[str, Any], outcome: str, reason: str
) -> None:
    assert judge(command, status(**fields)) == (Outcome[outcome], reason)


def test_rule_5_a_program_that_has_gone_or_was_started_again(room: Room) -> None:
    goal = room.begun()
    room.do(room.goals.tick(room.at))
    assert goal.phase is Phase.RUNNING
    room.do(room.goals.tick(room.at, gone=True))
    assert end(goal)[0] is Outcome.UNREACHABLE
    assert end(goal)[1].startswith("The program has gone: it is unknown whether the command was executed.")
    room.see(session=5, count=6)
    again = room.begun()
    room.see(session=6, count=9)
    assert end(again)[0] is Outcome.UNREACHABLE
    assert end(again)[1].startswith("The program was started again: ")


def test_rule_6_a_cancel_before_the_decision(room: Room) -> None:
    first, goal = room.come(Command.LOCK, "first"), room.come()
    room.do(room.goals.cancel(goal))
    room.answer(first, NO)
    assert end(goal) == (Outcome.NOT_EXECUTED, NOT_BEGUN)


def test_rule_6_a_cancel_while_the_program_is_asked_is_passed_on(room: Room) -> None:
    goal = room.come()
    room.do(room.goals.cancel(goal))
    room.answer(goal)
    assert room.done[1:] == [(Effect.REPORT_BEGIN, "a"), (Effect.CANCEL, "a")]
    room.see(cause=Cause.CANCELLED, reason="The grip was cancelled.")
    assert end(goal) == (Outcome.CANCELLED, "The grip was cancelled.")


@pytest.mark.parametrize("command", [Command.RELEASE, Command.LOCK, Command.UNLOCK])
def test_rule_6_of_goals_that_run_only_a_grip_is_cancelled(room: Room, command: Command) -> None:
    room.do(room.goals.cancel(room.begun(command)))
    assert room.done == []


@pytest.mark.parametrize("phase", Phase)
def test_rule_7_at_our_end_every_goal_gets_its_ending(room: Room, phase: Phase) -> None:
    goals = {Phase.ENDED: room.come(name="ended")}
    room.answer(goals[Phase.ENDED], NO)
    if phase is Phase.RUNNING:
        goals[phase] = room.begun()
    else:
        goals[Phase.ASKED], goals[Phase.WAITING] = room.come(), room.come()
    room.do(room.goals.close("HALMain", "See EndEffectorState.", room.at))
    wanted = {
        Phase.WAITING: (Outcome.REJECTED, "HALMain is ending: the goal was not begun."),
        Phase.ASKED: (
            Outcome.UNREACHABLE,
            "HALMain is ending. The program has not answered yet: whether the goal was begun is unknown.",
        ),
        Phase.RUNNING: (
            Outcome.UNREACHABLE,
            "HALMain is ending while a was at work, and does not see its end. See EndEffectorState.",
        ),
        Phase.ENDED: (Outcome.REJECTED, NO.reason),
    }
    assert end(goals[phase]) == wanted[phase]
    assert end(room.come()) == wanted[Phase.WAITING]
    assert room.goals.open == ()


def test_of_a_program_that_does_not_run_the_part_stays_held_and_the_rest_is_unknown() -> None:
    held = {"held": True, "outputs": (True,), "evidence": (Evidence.CONFIRMED,), "unlock_output": True}
    known = status(ee=State.GRIPPED, changer=ChangerState.LOCKED, lift_allowed=True, secure=True, **held)
    assert unknown_now(known) == status(ee=State.OFF, **held | {"evidence": (Evidence.UNKNOWN,)})


def test_a_reset_says_all_that_stays() -> None:
    assert reset_answer([Answer(True)]).accepted
    assert reset_answer([Answer(False, "One."), Answer(True), Answer(False, "Two.")]) == Answer(
        False, "One. Two."
    )
