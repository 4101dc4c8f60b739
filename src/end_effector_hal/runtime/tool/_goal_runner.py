"""Goals of the programs in this process: begun in the thread of the caller, waited for as long as it likes."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
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
    """How a command ended, with sensor evidence or with the reason in words.

    Attributes:
        outcome: in one word.
        state: of the end-effector, at the end.
        reason: empty for a success only.
        steps: attempts and times of the grip.
        seconds: from the command to its end; 0: it was not begun.
    """

    outcome: Outcome
    state: EndEffectorState
    reason: str = ""
    steps: tuple[StepReport, ...] = ()
    seconds: float = 0.0

    @property
    def succeeded(self) -> bool:
        """Whether the sensors prove what was asked for."""
        return self.outcome is Outcome.SUCCEEDED


@dataclass(frozen=True, slots=True)
class Refused(Result):
    """A command that was not begun, and why; UNREACHABLE: it may have been begun."""

    def wait(self) -> Refused:
        """Itself: it is over."""
        return self


class CommandedProgram(Protocol):
    """A program that executes commands."""

    @property
    def status(self) -> Status:
        """The newest one."""

    @property
    def alive(self) -> bool:
        """Whether it works."""

    def command(self, name: str) -> Answer:
        """Ask it to begin what a channel of its automata is for; statuses of the beginning come before the answer."""

    def wait(self, until: Callable[[Status], bool], timeout_s: float | None = None) -> bool:
        """Block until a status satisfies ``until``; False when the time is over or the program has ended."""


class GoalRunner:
    """Begins goals, one at a time; thread-safe.

    Args:
        programs: ``grip`` and ``tool_change``.
        tool: gives the status of the whole tool.
    """

    def __init__(self, programs: Mapping[str, CommandedProgram], tool: Callable[[], Status]) -> None:
        self._programs, self._tool = programs, tool
        self._goals: Goals[RunningGoal] = Goals({name: f"The {name} program" for name in programs})
        self._lock = threading.Lock()

    def begin(self, command: Command) -> Refused | RunningGoal:
        """Ask for a command and wait for the decision, not for its end.

        Raises:
            UsageError: it is not GRIP, RELEASE, LOCK or UNLOCK.
        """
        if command not in GOAL_COMMANDS:
            raise UsageError(f"{command!r} is not a goal.", todo="Goals are GRIP, RELEASE, LOCK and UNLOCK.")
        goal = RunningGoal(command, CHANNELS[command], runner=self)
        program = self._programs[goal.program]
        with self._lock:
            self._look()
            self._keep(self._goals.begin(goal, now_us()))
            if goal.result is None:
                answer = program.command(CHANNELS[command])
                self._goals.see(goal.program, program.status, now_us())
                self._keep(self._goals.answer(goal, answer, now_us()))
        return goal.result if isinstance(goal.result, Refused) else goal

    def wait(self, goal: RunningGoal, timeout_s: float | None) -> None:
        """Block until a goal is over, or the time."""
        program = self._programs[goal.program]
        program.wait(lambda status: goal.result is not None or is_over(status), timeout_s)
        with self._lock:
            self._look()

    def close(self, todo: str) -> None:
        """We end: a goal that runs gets its ending now, ``todo`` in it, and none is begun any more."""
        with self._lock:
            self._look()
            self._keep(self._goals.close("This process", todo, now_us()))

    def _look(self) -> None:
        """See the newest statuses: the end of a goal is in them."""
        at = now_us()
        for name, program in self._programs.items():
            self._keep(self._goals.see(name, program.status, at))
        gone = [name for name, program in self._programs.items() if not program.alive]
        self._keep(self._goals.tick(at, gone))

    def _keep(self, effects: list[GoalEffect[RunningGoal]]) -> None:
        for todo, goal in effects:
            if todo is Effect.REPORT_END and goal.ending is not None:
                ending, status = goal.ending, self._tool()
                state = status.ee
                if ending.seconds is None:
                    goal.result = Refused(ending.outcome, state, ending.reason)
                else:
                    steps = status.steps if goal.program == "grip" else ()
                    goal.result = Result(ending.outcome, state, ending.reason, steps, ending.seconds)


@dataclass(slots=True, eq=False)
class RunningGoal(Goal):
    """A command that was begun.

    Attributes:
        result: how it ended; None: nobody has seen its end yet.
    """

    runner: GoalRunner = field(kw_only=True)
    result: Result | None = None

    def wait(self, timeout_s: float | None = None) -> Result:
        """Wait for its end; raises TimeoutError when that takes longer."""
        if self.result is None:
            self.runner.wait(self, timeout_s)
        if self.result is None:
            raise TimeoutError(
                f"{self.name} has not finished after {timeout_s:g} s and is still running. "
                "Call wait() again, or cancel()."
            )
        return self.result
