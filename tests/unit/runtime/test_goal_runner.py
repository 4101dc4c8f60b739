"""A goal ends with its own end, whatever another client commands next."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from end_effector_hal.control import Answer, Status
from end_effector_hal.control.goals import Outcome
from end_effector_hal.runtime import GoalRunner, RunningGoal
from end_effector_hal.vocabulary import Command, EndEffectorState, Evidence
from tests.support.lone_program import Tool

STATES = {
    EndEffectorState.STAND_BY: Command.NONE,
    EndEffectorState.GRIPPING: Command.GRIP,
    EndEffectorState.GRIPPED: Command.NONE,
    EndEffectorState.RELEASING: Command.RELEASE,
}


def at(state: EndEffectorState, count: int) -> Status:
    status = replace(Tool().program.status, ee=state, command=STATES[state], count=count, begun=7)
    level = Evidence.CONFIRMED if state is EndEffectorState.GRIPPED else Evidence.GONE
    return replace(status, evidence=(level,) * len(status.evidence))


class Scripted:
    """A program whose statuses a test publishes."""

    alive = True

    def __init__(self) -> None:
        self.status = at(EndEffectorState.STAND_BY, 1)
        self.runner = GoalRunner(self, lambda: self.status)

    def command(self, _name: str, _part: str = "") -> Answer:
        self.publish(at(EndEffectorState.GRIPPING, 2))
        return Answer(True, count=2)

    def publish(self, status: Status) -> None:
        self.status = status
        self.runner.see(status)

    def wait(self, until: Callable[[Status], bool], timeout_s: float | None = None) -> bool:
        return until(self.status)

    def acknowledge(self) -> None: ...

    def set_actuator(self, name: str, active: bool) -> Answer:
        return Answer(False)


@pytest.mark.timeout(20)
@pytest.mark.parametrize("timeout_s", [0.0, None])
def test_a_goal_ends_with_its_own_end_whatever_is_commanded_next(timeout_s: float | None) -> None:
    program = Scripted()
    goal = program.runner.begin(Command.GRIP)
    assert isinstance(goal, RunningGoal)
    for number, state in enumerate((EndEffectorState.GRIPPED, EndEffectorState.RELEASING), 3):
        program.publish(at(state, number))  # by another client, before anybody waits
    result = goal.wait(timeout_s)
    assert (result.outcome, result.state) == (Outcome.SUCCEEDED, EndEffectorState.GRIPPED)


def test_a_refused_command_is_waited_for_like_one_that_runs() -> None:
    program = Scripted()
    assert isinstance(program.runner.begin(Command.GRIP), RunningGoal)
    refused = program.runner.begin(Command.GRIP)
    assert refused.wait(1.0) is refused
