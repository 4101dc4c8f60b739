"""Begin goals in the caller's thread, and wait for their ends as long as the caller wants."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

from end_effector_hal.control import Answer, Status, StepReport
from end_effector_hal.control.goals import (
    CHANNELS,
    GOAL_COMMANDS,
    Effect,
    Goal,
    GoalEffect,
    Goals,
    Outcome,
    is_over,
)
from end_effector_hal.errors import UsageError
from end_effector_hal.vocabulary import Command, EndEffectorState
from end_effector_hal.wires import now_us


@dataclass(frozen=True, slots=True)
class Result:
    """The end of a command, with sensor evidence or with the reason in words.

    Attributes:
        outcome: the outcome in one word.
        state: state of the end-effector at the end.
        reason: a sentence; empty only for a success.
        steps: attempts and times of the grip.
        seconds: time from the command to its end; 0: it was not begun.
    """

    outcome: Outcome
    state: EndEffectorState
    reason: str = ""
    steps: tuple[StepReport, ...] = ()
    seconds: float = 0.0

    @property
    def succeeded(self) -> bool:
        """Whether the sensors prove the requested result."""
        return self.outcome is Outcome.SUCCEEDED


@dataclass(frozen=True, slots=True)
class Refused(Result):
    """A command that was not begun, and why; if the outcome is UNREACHABLE, it may have been begun."""

    def wait(self, timeout_s: float | None = None) -> Refused:
        """Return itself: it is over."""
        return self


class CommandedProgram(Protocol):
    """A program that executes commands, in this process or in another one."""

    @property
    def status(self) -> Status:
        """The latest status."""

    @property
    def alive(self) -> bool:
        """Whether the program works."""

    def command(self, name: str, part: str = "") -> Answer:
        """Give the program a command by its channel; the first statuses are published before the answer.

        ``part``: the part that is to be gripped; empty: the default one.
        """

    def wait(self, until: Callable[[Status], bool], timeout_s: float | None = None) -> bool:
        """Block until a status satisfies ``until``; return False on a time-out or when the program has ended."""

    def acknowledge(self) -> None:
        """Acknowledge the alarms that are over."""

    def set_actuator(self, name: str, active: bool) -> Answer:
        """Drive one actuator in maintenance, and wait for the proof of its sensor."""


class GoalRunner:
    """Begins goals, one at a time; thread-safe.

    Args:
        program: the program.
        tool: returns the status of the whole tool.
    """

    def __init__(self, program: CommandedProgram, tool: Callable[[], Status]) -> None:
        self._program, self._tool = program, tool
        self._goals: Goals[RunningGoal] = Goals("The HAL")
        self._lock = threading.Lock()
        self._count = 0  # number of the goal's first status
        self._ended: Status | None = None  # the first status of the goal in which no command is executed

    def see(self, status: Status) -> None:
        """Keep the status that ends the running goal; another client may give the next command at once. Never waits."""
        if self._ended is None and is_over(status) and status.count >= self._count:
            self._ended = status

    def begin(self, command: Command, part: str = "") -> Refused | RunningGoal:
        """Give a command and wait for the decision, not for its end; ``part``: what is to be gripped.

        Raises:
            UsageError: it is not GRIP, RELEASE, LOCK or UNLOCK.
        """
        if command not in GOAL_COMMANDS:
            raise UsageError(f"{command!r} is not a goal.", todo="Goals are GRIP, RELEASE, LOCK and UNLOCK.")
        goal = RunningGoal(command, CHANNELS[command], runner=self)
        with self._lock:
            self._look()
            self._keep(self._goals.begin(goal, now_us()))
            if goal.result is None:
                answer = self._program.command(CHANNELS[command], part)
                self._ended, self._count = None, answer.count
                self._goals.see(self._program.status, now_us())
                self._keep(self._goals.answer(goal, answer, now_us()))
        return goal.result if isinstance(goal.result, Refused) else goal

    def wait(self, goal: RunningGoal, timeout_s: float | None) -> None:
        """Block until a goal is over, or until the time-out."""

        def is_news(status: Status) -> bool:
            followed = goal.session in (0, status.begun) and status.count > 0
            return not followed or (status.count >= goal.count and is_over(status))

        until_s = math.inf if timeout_s is None else time.monotonic() + timeout_s
        while goal.result is None:  # again if the program was lost, and was back before it was looked at
            left_s = None if timeout_s is None else max(0.0, until_s - time.monotonic())
            self._program.wait(
                lambda status: goal.result is not None or self._ended is not None or is_news(status), left_s
            )
            with self._lock:
                self._look()
            if time.monotonic() >= until_s:
                break

    def close(self, todo: str) -> None:
        """End all goals: a running goal ends now, with ``todo`` in its ending, and no goal begins any more."""
        with self._lock:
            self._look()
            self._keep(self._goals.close("This process", todo, now_us()))

    def _look(self) -> None:
        """Process the latest statuses, which contain the end of a goal."""
        at = now_us()
        if (ended := self._ended) is not None:
            self._keep(self._goals.see(ended, at))
        self._keep(self._goals.see(self._program.status, at))
        self._keep(self._goals.tick(at, gone=not self._program.alive))

    def _keep(self, effects: list[GoalEffect[RunningGoal]]) -> None:
        for todo, goal in effects:
            if todo is Effect.REPORT_END and goal.ending is not None:
                ending = goal.ending
                if ending.seconds is None:
                    goal.result = Refused(ending.outcome, self._tool().ee, ending.reason)
                else:
                    status = self._ended or self._tool()
                    steps = status.steps if goal.command in (Command.GRIP, Command.RELEASE) else ()
                    goal.result = Result(ending.outcome, status.ee, ending.reason, steps, ending.seconds)


@dataclass(slots=True, eq=False)
class RunningGoal(Goal):
    """A command that was begun.

    Attributes:
        result: how it ended; None: its end has not been seen yet.
    """

    runner: GoalRunner = field(kw_only=True)
    result: Result | None = None

    def wait(self, timeout_s: float | None = None) -> Result:
        """Wait for the end of the command and return its result; raises TimeoutError on a time-out."""
        if self.result is None:
            self.runner.wait(self, timeout_s)
        if self.result is None:
            raise TimeoutError(
                f"{self.name} has not finished after {timeout_s:g} s and is still running. "
                "Call wait() again, or cancel()."
            )
        return self.result
