"""Serve the actions of HALMain: receive goals, apply the rules of `control.goals`, send answers."""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from end_effector_hal.control import Answer, Status
from end_effector_hal.control.goals import CHANNELS, Effect, Ending, Goal, GoalEffect, Goals, Outcome, Phase
from end_effector_hal.runtime import Tool
from end_effector_hal.vocabulary import Command
from end_effector_hal.wires import now_us

from ._goal_types import GoalType
from .transport import ClientGoal, NodeTransport, StateMessage


@dataclass(slots=True, eq=False)
class ServedGoal(Goal):
    """A goal of a client."""

    type: GoalType = field(kw_only=True)
    client: ClientGoal = field(kw_only=True)


class ServedGoals:
    """Serves the actions; thread-safe.

    A decision is made in the thread that delivers the message, under one lock. One thread at a time carries out the
    effects, in the order of the decisions: a thread that finds another one at work leaves its effects to that thread.
    So no thread waits for an action server, which holds its lock while it calls back. Each command has a thread of its
    own, because the tool may answer late.

    Args:
        node: the transport that serves the actions; its log records how each goal ended.
        types: the goals of each action.
        tool: executes the commands.
        state: returns the newest EndEffectorState.
    """

    def __init__(
        self,
        node: NodeTransport,
        types: Iterable[GoalType],
        tool: Tool,
        state: Callable[[], StateMessage],
    ) -> None:
        self._tool, self._state, self._log = tool, state, node.log
        self._lock, self._turn = threading.Lock(), threading.Lock()
        self._goals: Goals[ServedGoal] = Goals("The HAL")
        self._effects: deque[GoalEffect[ServedGoal]] = deque()
        self._servers = [
            node.action_server(
                each.action,
                partial(self._came, each),
                partial(self._cancelled, each),
                partial(self._result, each),
            )
            for each in types
            if node.offers(each.action)
        ]

    def on_status(self, status: Status) -> None:
        """Process a new status of the tool, which may continue or end the running goal."""
        self._decide(lambda at: self._goals.see(status, at))

    def tick(self, *, gone: bool) -> None:
        """Send feedback with the time left, and end a goal if the HAL is gone or does not answer; called regularly."""
        self._decide(lambda at: self._goals.tick(at, gone=gone))

    def close(self) -> None:
        """Answer every goal while the topics are still open, and reject later goals."""
        todo = f"{self._tool.ending()} See EndEffectorState once HALMain is back.".lstrip()
        with self._lock:
            self._effects += self._goals.close("HALMain", todo, now_us())
        with self._turn:
            self._carry_out()
        for server in self._servers:
            server.close()

    def _came(self, kind: GoalType, client: ClientGoal) -> None:
        command = kind.command(client.request)
        if isinstance(command, Command):
            part = kind.part(client.request)
            goal = ServedGoal(command, kind.action.name, kind.is_target, type=kind, client=client, part=part)
            self._decide(lambda at: self._goals.begin(goal, at))
        else:
            self._answer(kind, client, Ending(Outcome.REJECTED, command), None)

    def _cancelled(self, kind: GoalType, client: ClientGoal) -> bool:
        taken = False

        def decide(_at: int) -> list[GoalEffect[ServedGoal]]:
            nonlocal taken
            for goal in self._goals.open:
                if goal.type is kind and goal.client == client:
                    # a program that was asked for a drop or a change of the tool will not be asked to stop
                    taken = goal.command is Command.GRIP or goal.phase is Phase.WAITING
                    return self._goals.cancel(goal)
            return []

        self._decide(decide)
        return taken

    def _decide(self, decide: Callable[[int], list[GoalEffect[ServedGoal]]]) -> None:
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

    def _do(self, todo: Effect, goal: ServedGoal) -> None:
        if todo is Effect.ASK:
            self._give(
                CHANNELS[goal.command],
                lambda answer: self._decide(lambda at: self._goals.answer(goal, answer, at)),
                goal.part,
            )
        elif todo is Effect.GIVE_UP:
            pass  # its thread ends by itself, and the goals ignore a late answer
        elif todo is Effect.CANCEL:
            self._give("cancel", lambda _: None)  # refused where nothing is to be unwound
        elif todo is Effect.REPORT_BEGIN:
            goal.client.begin()
        elif todo is Effect.REPORT_PROGRESS:
            goal.client.publish_feedback(goal.type.feedback(self._state()))
        elif goal.ending is not None:
            self._answer(goal.type, goal.client, goal.ending, goal.command)

    def _give(self, command: str, then: Callable[[Answer], None], part: str = "") -> None:
        """Give a command in a thread of its own, and call ``then`` with the decision."""
        try:
            threading.Thread(
                target=lambda: then(self._tool.command(command, part)), name=command, daemon=True
            ).start()
        except RuntimeError as error:  # no thread
            then(Answer(False, f"The HAL cannot be asked: {error}."))

    def _answer(self, kind: GoalType, client: ClientGoal, ending: Ending, command: Command | None) -> None:
        wanted = ending.outcome in (Outcome.SUCCEEDED, Outcome.CANCELLED, Outcome.NOT_EXECUTED)
        # where the result has no place for a reason this line is all that says it
        level = logging.INFO if wanted or kind.says_why else logging.WARNING
        self._log.log(level, "%s: %s", kind.action.name, f"{ending.outcome.name}. {ending.reason}".rstrip())
        client.end(ending, self._result(kind, ending, command))

    def _result(self, kind: GoalType, ending: Ending, command: Command | None = None) -> Any:
        return kind.result(self._state(), ending, command)
