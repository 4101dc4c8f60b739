"""How commands are given, and what each has come to, when its program ends in the middle or another client commands."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from end_effector_hal.control import Answer, Status, unknown_now
from end_effector_hal.control.goals import Outcome
from end_effector_hal.errors import UsageError
from end_effector_hal.runtime import (
    EndEffector,
    GoalRunner,
    RunningGoal,
    ScriptCommand,
    read_command,
    read_script,
)
from end_effector_hal.runtime.tool._listeners import Audience
from end_effector_hal.vocabulary import ChangerState, Command, EndEffectorState, Evidence
from end_effector_hal.vocabulary import EndEffectorState as State
from end_effector_hal.wires import PipedLines
from end_effector_hal.wires._piped_lines import LONGEST_LINE
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


# A goal ends with its own end, whatever another client commands next.


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


# The Supervisor's script needs no ROS.


def test_steps_are_separated_by_semicolons_or_line_ends() -> None:
    assert read_script("lock; grip ;wait 2.5\n\n RELEASE;; quit # the end; grip\n") == (
        ScriptCommand(Command.LOCK),
        ScriptCommand(Command.GRIP),
        ScriptCommand(wait_s=2.5),
        ScriptCommand(Command.RELEASE),
        ScriptCommand(Command.QUIT),
    )


def test_drop_is_the_release_of_table_ii() -> None:
    assert read_script("drop") == read_script("release") == (ScriptCommand(Command.RELEASE),)


def test_an_ampersand_sends_to_the_background() -> None:
    assert read_script("grip &; wait 1; cancel") == (
        ScriptCommand(Command.GRIP, background=True),
        ScriptCommand(wait_s=1.0),
        ScriptCommand(Command.CANCEL),
    )
    assert read_command("grip&") == ScriptCommand(Command.GRIP, background=True)


def test_an_empty_script_holds_nothing() -> None:
    assert read_script(" ;\n# nothing\n;") == ()


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("lock; gripp; quit", "'gripp' is not a command. Did you mean 'grip'?"),
        ("fly", "'fly' is not a command. There are: "),
        ("grip 3", "'grip 3': nothing may follow 'grip'."),
        ("lock grip", "nothing may follow 'lock'. Separate commands by ';'."),
        ("grip & wait 3", "nothing may follow 'grip'. Separate commands by ';', also behind an '&'."),
        ("scenario ", "'scenario': expected is 'scenario <text>', for example 'scenario nominal'."),
        ("wait", "'wait': expected is 'wait <seconds>'"),
        ("wait soon", "expected is 'wait <seconds>'"),
        ("wait -1", "expected is 'wait <seconds>'"),
        ("wait nan", "expected is 'wait <seconds>'"),
        ("wait inf", "expected is 'wait <seconds>'"),
        ("wait 1 2", "expected is 'wait <seconds>'"),
        ("wait 1 &", "a wait cannot go on in the background"),
        ("&", "'&' is not a command."),
    ],
)
def test_what_is_no_script_is_said_in_a_sentence(text: str, expected: str) -> None:
    with pytest.raises(UsageError, match=re.escape(expected)):
        read_script(text)


def test_a_scenario_is_for_the_testbench_as_it_was_typed() -> None:
    assert read_script("Scenario  leak:Cup_A:2, supply:300 ; grip") == (
        ScriptCommand(scenario="leak:Cup_A:2, supply:300"),
        ScriptCommand(Command.GRIP),
    )


def test_a_resume_and_a_reset_are_no_commands_of_table_ii() -> None:
    assert read_command("resume") == ScriptCommand(resume=True)
    assert read_command("reset") == ScriptCommand(reset=True)
    with pytest.raises(UsageError, match="Did you mean 'reset'"):
        read_command("rest")


# Lines of an input that nobody types.


def test_lines_come_in_pieces_and_the_last_may_lack_its_end() -> None:
    read, write = os.pipe()
    lines = PipedLines(read)
    for piece in (b"scenario nom", b"inal\nscenario noise:0.1\nqu"):
        os.write(write, piece)
    assert [lines.next(), lines.next()] == ["scenario nominal", "scenario noise:0.1"]
    os.write(write, b"it")
    os.close(write)
    assert [lines.next(), lines.next()] == ["quit", None]
    os.close(read)


def test_a_line_without_an_end_is_bounded() -> None:
    read, write = os.pipe()
    lines, sent = PipedLines(read), 0
    os.set_blocking(write, False)
    while sent < 2 * LONGEST_LINE:  # a pipe holds less than that
        sent += os.write(write, b"x" * 4_096)
        if sent == LONGEST_LINE:
            line = lines.next()
    assert line == "x" * LONGEST_LINE
    os.close(write)
    assert lines.next() == "x" * LONGEST_LINE
    os.close(read)


def test_an_input_that_is_closed_or_another_programs_has_ended() -> None:
    assert PipedLines(-1).next() is None
