"""The four actions of HALMain: messages in, the rules of `control.goals`, messages out."""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from end_effector_msgs.msg import EndEffectorFeedback, EndEffectorResult, State

from end_effector_hal.control import Status
from end_effector_hal.control.goals import Effect, Goal, Goals, Outcome, Todo
from end_effector_hal.nodes.interface import (
    ACTIONS,
    GRIP,
    GRIP_COMMAND,
    TOOL_CHANGE,
    TOOL_CHANGE_COMMAND,
    Action,
)
from end_effector_hal.ros1.connections import Commander
from end_effector_hal.vocabulary import Command
from end_effector_hal.wires import now_us

from ._action_server import GoalServer
from ._later import Later

_PROGRAMS = {GRIP: "grip", TOOL_CHANGE: "tool_change"}


@dataclass(slots=True, eq=False)
class ServedGoal(Goal):
    """A goal of a client; ``handle`` is that of actionlib."""

    handle: Any = field(kw_only=True)


class ServedGoals:
    """Serves the actions; thread-safe.

    A decision is made in the thread that brings the message, under one lock. Its effects are carried out after one
    another, in the order of the decisions, by one thread at a time: whoever finds another one at it leaves them to
    that one. So no thread waits for an action server, whose lock is held while it calls back.

    Args:
        state: gives the newest EndEffectorState.
        log: gets how each goal ended.
    """

    def __init__(self, state: Callable[[], Any], log: logging.Logger) -> None:
        self._state, self._log = state, log
        self._lock, self._turn = threading.Lock(), threading.Lock()
        self._goals: Goals[ServedGoal] = Goals({name: f"The node {node}" for node, name in _PROGRAMS.items()})
        self._effects: deque[Effect[ServedGoal]] = deque()
        self._commanders = {"grip": Commander(GRIP_COMMAND), "tool_change": Commander(TOOL_CHANGE_COMMAND)}
        self._later = Later(log)
        self._servers = [
            GoalServer(
                action,
                partial(self._came, action),
                partial(self._cancelled, action),
                self._result,
                self._later,
            )
            for action in ACTIONS
        ]
        for server in self._servers:
            server.start()

    def on_status(self, node: str, status: Any) -> None:
        """A node has a new status: a goal that it executes comes further, or is over."""
        program, seen, session, count = _PROGRAMS[node], _status(status), status.since_us, status.count
        self._decide(lambda at: self._goals.see(program, seen, at, session=session, count=count))

    def tick(self, gone: tuple[str, ...]) -> None:
        """Periodically: feedback with the time left; a goal whose node has gone, or does not answer, ends."""
        self._decide(lambda at: self._goals.tick(at, [_PROGRAMS[node] for node in gone]))

    def close(self) -> None:
        """Answer every goal while the topics are still open, and reject what still comes."""
        todo = "What is held stays held. See EndEffectorState once HALMain is back."
        with self._lock:
            self._effects += self._goals.close("HALMain", todo, now_us())
        with self._turn:
            self._carry_out()
        self._later.close()

    def _came(self, action: Action, handle: Any) -> None:
        goal = ServedGoal(Command(action.command), action.name, handle=handle)
        self._decide(lambda at: self._goals.begin(goal, at))

    def _cancelled(self, action: Action, handle: Any) -> None:
        def decide(_at: int) -> list[Effect[ServedGoal]]:
            same = [goal for goal in self._goals.open if goal.name == action.name and goal.handle == handle]
            return self._goals.cancel(same[0]) if same else []

        self._decide(decide)

    def _decide(self, decide: Callable[[int], list[Effect[ServedGoal]]]) -> None:
        with self._lock:
            self._effects += decide(now_us())
        # an effect that comes after the last look of the thread that has the turn is found by this one
        while self._effects and self._turn.acquire(blocking=False):
            try:
                self._carry_out()
            finally:
                self._turn.release()

    # By one thread at a time.

    def _carry_out(self) -> None:
        while self._effects:
            todo, goal = self._effects.popleft()
            try:
                self._do(todo, goal)
            except Exception:  # noqa: BLE001 the other goals get their answers all the same
                self._log.exception("%s: %s failed", goal.name, todo.name)

    def _do(self, todo: Todo, goal: ServedGoal) -> None:
        commander = self._commanders[goal.program]
        if todo is Todo.ASK:
            commander.send(
                goal.command, lambda answer: self._decide(lambda at: self._goals.answer(goal, answer, at))
            )
        elif todo is Todo.GIVE_UP:
            commander.give_up()
        elif todo is Todo.CANCEL:
            commander.send(Command.CANCEL, lambda _: None)  # refused where nothing is to be unwound
        elif todo is Todo.SAY_BEGUN:
            goal.handle.set_accepted()
        elif todo is Todo.SAY_PROGRESS:
            goal.handle.publish_feedback(self._feedback())
        else:
            self._say_ended(goal)

    def _say_ended(self, goal: ServedGoal) -> None:
        if (ending := goal.ending) is None:
            return
        outcome, reason, handle = ending.outcome, ending.reason, goal.handle
        self._log.info("%s: %s", goal.name, f"{outcome.name}. {reason}".rstrip())
        result = self._result(outcome, reason)
        end = {Outcome.NOT_EXECUTED: handle.set_canceled}.get(outcome, handle.set_rejected)
        if ending.seconds is not None:
            ends = {Outcome.SUCCEEDED: handle.set_succeeded, Outcome.CANCELLED: handle.set_canceled}
            end = ends.get(outcome, handle.set_aborted)
            result.seconds = ending.seconds
            result.steps = self._state().steps if goal.command is Command.GRIP else []
        end(result, reason)

    def _result(self, outcome: Outcome, reason: str) -> Any:
        return EndEffectorResult(outcome=outcome, state=self._state().state, reason=reason)

    def _feedback(self) -> Any:
        state = self._state()
        return EndEffectorFeedback(
            state=state.state,
            actuator=state.actuator,
            attempt=state.attempt if state.state == State.GRIPPING else 0,
            attempts_allowed=state.attempts_allowed,
            time_left_s=state.time_left_s,
        )


def _status(message: Any) -> Status:
    return Status(
        at=message.at_us,
        ee=message.state,
        command=message.command,
        actuators=message.actuators,
        outputs=message.outputs,
        evidence=message.evidence,
        cause=message.cause,
        reason=message.reason,
        changer=message.tool_changer,
    )
