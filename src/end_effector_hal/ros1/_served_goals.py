"""The four actions: one goal at a time, accepted or refused by the automata, followed to its end."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import rospy
from end_effector_msgs.msg import EndEffectorFeedback, EndEffectorResult, Outcome, State

from end_effector_hal.trace import Command
from end_effector_hal.wires import now_us

from ._action_server import action_server
from ._commander import Commander
from ._judgement import is_over, judge
from ._node import constant_name
from ._table import ACTIONS, GRIP, GRIP_COMMAND, TOOL_CHANGE, TOOL_CHANGE_COMMAND, Action

_SERVERS = {
    Command.GRIP: GRIP,
    Command.RELEASE: GRIP,
    Command.LOCK: TOOL_CHANGE,
    Command.UNLOCK: TOOL_CHANGE,
}

_log = logging.getLogger(__name__)
_ANSWER_AFTER_S = 0.1
"""``SimpleActionClient`` does not know its goal before ``send_goal`` has returned: of an answer that comes sooner it
hears nothing, and waits for ever."""


@dataclass(slots=True)
class _Running:
    handle: Any
    action: Action
    node: str
    begun_us: int
    since_us: int
    count: int | None = None
    """Of the first status that is certain to follow the acceptance; None: not accepted yet."""


class ServedGoals:
    """Bookkeeping of goals.

    A second goal is rejected, it never preempts. No method of an action server is called under the lock: it
    takes the server's own, which the server holds while it calls back.

    Args:
        state: gives the newest EndEffectorState.
    """

    def __init__(self, state: Callable[[], Any]) -> None:
        self._state = state
        self._lock = threading.Lock()
        self._running: _Running | None = None
        self._newest: dict[str, Any] = {}
        self._commanders = {GRIP: Commander(GRIP_COMMAND), TOOL_CHANGE: Commander(TOOL_CHANGE_COMMAND)}
        self._servers = [action_server(action, self._starter(action), self._on_cancel) for action in ACTIONS]

    def on_status(self, node: str, status: Any) -> None:
        """A unit has said something: tell the client, and end the goal if it is over."""
        self._newest[node] = status
        self._follow()

    def tick(self, gone: tuple[str, ...]) -> None:
        """Periodically: feedback with the time left; a goal whose node has gone ends."""
        running = self._running
        if running is None or running.count is None:
            return
        if running.node in gone:
            self._end(running, Outcome.UNREACHABLE, f"The node {running.node} has gone while it was at work.")
        else:
            running.handle.publish_feedback(self._feedback())

    def _starter(self, action: Action) -> Callable[[Any], None]:
        return lambda handle: self._start(action, handle)

    def _start(self, action: Action, handle: Any) -> None:
        node = _SERVERS[action.command]
        newest = self._newest.get(node)
        running = _Running(handle, action, node, now_us(), newest.since_us if newest is not None else 0)
        with self._lock:
            busy, self._running = self._running, self._running or running
        if busy is not None:
            todo = "Cancel it, or wait" if busy.action.command is Command.GRIP else "Wait"
            reason = f"{busy.action.name} is still running: one goal at a time. {todo} for its end."
            self._answer(running, handle.set_rejected, self._result(Outcome.REJECTED, reason, None), reason)
            return
        reply = self._commanders[node].ask(action.command)
        if not reply.accepted:
            with self._lock:
                self._running = None
            outcome = Outcome.REJECTED if reply.reached else Outcome.UNREACHABLE
            result = self._result(outcome, reply.reason, None)
            self._answer(running, handle.set_rejected, result, reply.reason)
            return
        handle.set_accepted()
        running.count = reply.count
        self._follow()

    def _follow(self) -> None:
        running = self._running
        if running is None or running.count is None:
            return
        status = self._newest.get(running.node)
        if status is None:
            return
        if running.since_us not in (0, status.since_us):
            why = f"The node {running.node} was started again while it was at work."
            self._end(running, Outcome.UNREACHABLE, why)
        elif status.count >= running.count:
            running.handle.publish_feedback(self._feedback())
            if is_over(status):
                self._end(running, *judge(running.action.command, status))

    def _end(self, running: _Running, outcome: int, reason: str) -> None:
        with self._lock:
            if self._running is not running:
                return
            self._running = None
        result = self._result(outcome, reason, running)
        handle = running.handle
        ends = {Outcome.SUCCEEDED: handle.set_succeeded, Outcome.CANCELLED: handle.set_canceled}
        self._answer(running, ends.get(outcome, handle.set_aborted), result, reason)

    @staticmethod
    def _answer(running: _Running, end: Callable[[Any, str], None], result: Any, reason: str) -> None:
        _log.info(
            "%s: %s", running.action.name, f"{constant_name(Outcome(), result.outcome)}. {reason}".rstrip()
        )

        def say() -> None:
            with suppress(rospy.ROSException):  # the node has ended meanwhile, and its topics are closed
                end(result, reason)

        early_s = _ANSWER_AFTER_S - (now_us() - running.begun_us) / 1e6
        if early_s > 0.0:
            threading.Timer(early_s, say).start()
        else:
            say()

    def _on_cancel(self, handle: Any) -> None:
        running = self._running
        if running is not None and running.handle == handle and running.action.command is Command.GRIP:
            # refused where nothing is to be unwound: the goal then ends as it would have
            self._commanders[GRIP].ask(Command.CANCEL)

    def _result(self, outcome: int, reason: str, running: _Running | None) -> Any:
        state = self._state()
        gripping = running is not None and running.action.command is Command.GRIP
        return EndEffectorResult(
            outcome=outcome,
            state=state.state,
            reason=reason,
            seconds=(now_us() - running.begun_us) / 1e6 if running is not None else 0.0,
            steps=state.steps if gripping else [],
        )

    def _feedback(self) -> Any:
        state = self._state()
        return EndEffectorFeedback(
            state=state.state,
            actuator=state.actuator,
            attempt=state.attempt if state.state == State.GRIPPING else 0,
            attempts_allowed=state.attempts_allowed,
            time_left_s=state.time_left_s,
        )
