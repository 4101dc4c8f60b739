"""What a command has come to, when its program ends in the middle: never a success."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from end_effector_hal.control import Answer, Status, unknown_now
from end_effector_hal.control.goals import Outcome
from end_effector_hal.runtime import EndEffector, GoalRunner
from end_effector_hal.runtime.tool._listeners import Audience
from end_effector_hal.vocabulary import ChangerState, Command
from end_effector_hal.vocabulary import EndEffectorState as State
from tests.support.lone_program import Tool


class Ended:
    """A program that takes a command, and ends before that is over."""

    alive = False

    def __init__(self, status: Status) -> None:
        self.status = status

    def command(self, _name: str, _part: str = "") -> Answer:
        return Answer(True)

    def wait(self, until: Callable[[Status], bool], timeout_s: float | None = None) -> bool:
        return until(self.status)


class LostForAMoment(Ended):
    """A program that is lost and back before anybody looks, and ends its command later."""

    alive = True

    def __init__(self, status: Status) -> None:
        super().__init__(replace(status, begun=5, count=7))
        lost, ended = unknown_now(self.status), replace(status, begun=5, count=8, command=Command.NONE)
        self._coming = [lost, replace(ended, ee=State.STAND_BY)]

    def wait(self, until: Callable[[Status], bool], timeout_s: float | None = None) -> bool:
        coming = self._coming.pop(0)
        if coming.count:
            self.status = coming
        return until(coming)


@pytest.fixture
def tool() -> Any:
    tool: Any = object.__new__(EndEffector)
    tool._audience = Audience(lambda: None)
    status = replace(Tool().program.status, ee=State.RELEASING, command=Command.RELEASE)
    tool._program = Ended(replace(status, changer=ChangerState.LOCKED))
    tool._goals = GoalRunner(tool._program, lambda: tool.status)
    return tool


@pytest.mark.parametrize("name", ["grip", "drop", "lock", "unlock"])
def test_a_program_that_ends_has_not_succeeded_and_says_so(tool: Any, name: str) -> None:
    outcome = getattr(tool, name)()
    assert not outcome.succeeded
    assert outcome.state == State.RELEASING
    assert outcome.outcome is Outcome.UNREACHABLE
    assert outcome.reason.startswith("The HAL has gone: it is unknown whether the command was executed")


def test_the_end_of_a_command_is_waited_for_although_its_program_was_lost_for_a_moment(tool: Any) -> None:
    program = LostForAMoment(tool._program.status)
    tool._program, tool._goals = program, GoalRunner(program, lambda: program.status)  # type: ignore[arg-type]
    assert tool.drop().succeeded


def test_an_answer_that_was_not_given_in_time_is_not_a_refusal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "end_effector_hal.runtime.programs._serial_worker.SerialWorker.ask", lambda *_, **__: None
    )
    answer = Tool().program.command("drop")
    assert (answer.accepted, answer.decided) == (False, False)
    assert answer.reason == "The HAL does not answer."
