"""The four actions: one goal at a time, accepted or refused by the automata, followed to its end."""

from __future__ import annotations

import logging
import queue
import threading
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from actionlib_msgs.msg import GoalStatus
from end_effector_msgs.msg import EndEffectorFeedback, EndEffectorResult, Outcome, State

from end_effector_hal.nodes.interface import (
    ACTIONS,
    GRIP,
    GRIP_COMMAND,
    TOOL_CHANGE,
    TOOL_CHANGE_COMMAND,
    Action,
)
from end_effector_hal.ros1.connections import Commander, Reply, constant_name
from end_effector_hal.vocabulary import Command
from end_effector_hal.wires import now_us

from ._action_server import OVERTAKEN, GoalServer
from ._judgement import is_over, judge
from ._later import Later

_SERVERS = {
    Command.GRIP: GRIP,
    Command.RELEASE: GRIP,
    Command.LOCK: TOOL_CHANGE,
    Command.UNLOCK: TOOL_CHANGE,
}
_ENDS = "HALMain is ending"


@dataclass(slots=True, eq=False)
class _Goal:
    handle: Any
    action: Action
    node: str
    came_us: int
    since_us: int = 0
    """The start of its node, when it was asked; 0: not known."""
    count: int = 0
    """Of the first status that is certain to follow the acceptance."""
    asked: bool = False


class ServedGoals:
    """Bookkeeping of goals.

    - Goals are decided one after the other, in the order in which they came, by a thread of their own: the node that
      executes them is asked, for 4 s at most. A goal that waits for its decision is in nobody's way.
    - Only a goal that was accepted runs. A second one is rejected, it never preempts.
    - Whoever waited while a node did not answer gets the same answer, and that node is not asked once more for it.
    - At the end every goal is answered, while the topics are still open.

    No method of an action server is called under the lock: it takes the server's own, which the server holds while
    it calls back. ``_turn`` is held while a decision becomes known; no callback of a server takes it.

    Args:
        state: gives the newest EndEffectorState.
        log: gets what should not have happened.
    """

    def __init__(self, state: Callable[[], Any], log: logging.Logger) -> None:
        self._state, self._log = state, log
        self._lock, self._turn = threading.Lock(), threading.Lock()
        self._running: _Goal | None = None
        self._undecided: list[_Goal] = []
        self._jobs: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._silent: dict[str, tuple[int, Reply]] = {}
        self._newest: dict[str, Any] = {}
        self._commanders = {GRIP: Commander(GRIP_COMMAND), TOOL_CHANGE: Commander(TOOL_CHANGE_COMMAND)}
        self._later = Later(log)
        self._servers = [
            GoalServer(action, self._starter(action), self._on_cancel, self._result, self._later)
            for action in ACTIONS
        ]
        threading.Thread(target=self._run, name="goals", daemon=True).start()
        for server in self._servers:
            server.start()

    def on_status(self, node: str, status: Any) -> None:
        """A unit has said something: tell the client, and end the goal if it is over."""
        self._newest[node] = status
        self._follow()

    def tick(self, gone: tuple[str, ...]) -> None:
        """Periodically: feedback with the time left; a goal whose node has gone ends."""
        running = self._running
        if running is None:
            return
        if running.node in gone:
            self._end(running, Outcome.UNREACHABLE, f"The node {running.node} has gone while it was at work.")
        else:
            running.handle.publish_feedback(self._feedback())

    def close(self) -> None:
        """Answer every goal, and reject what still comes."""
        for server in self._servers:
            server.close(f"{_ENDS}: the goal was not begun.")
        with self._turn:
            with self._lock:
                undecided, self._undecided = self._undecided, []
            for goal in undecided:
                if goal.asked:
                    why = f"{_ENDS}, and {goal.node} has not answered yet: whether the goal was begun is unknown."
                    self._refuse(goal, Outcome.UNREACHABLE, why)
                else:
                    self._refuse(goal, Outcome.REJECTED, f"{_ENDS}: the goal was not begun.")
            if (running := self._running) is not None:
                why = f"{_ENDS} while {running.action.name} was at work, and does not see its end"
                todo = "What is held stays held. See EndEffectorState once HALMain is back."
                self._end(running, Outcome.UNREACHABLE, f"{why}. {todo}")
        self._later.close()

    def _starter(self, action: Action) -> Callable[[Any], None]:
        return lambda handle: self._start(action, handle)

    def _start(self, action: Action, handle: Any) -> None:
        goal = _Goal(handle, action, _SERVERS[action.command], now_us())
        with self._lock:
            self._undecided.append(goal)
        self._jobs.put(partial(self._decide, goal))

    def _on_cancel(self, handle: Any) -> None:
        self._jobs.put(partial(self._cancel, handle))

    # In the thread of the decisions.

    def _run(self) -> None:
        while True:
            job = self._jobs.get()
            try:
                job()
            except Exception:  # noqa: BLE001 the next goal is decided all the same
                self._log.exception("a goal could not be decided")

    def _decide(self, goal: _Goal) -> None:
        running = self._running
        recalled = goal.handle.get_goal_status().status == GoalStatus.RECALLING
        free = running is None and not recalled
        reply = self._ask(goal) if free else Reply(False, "")
        with self._turn:
            with self._lock:
                if goal not in self._undecided:
                    return  # it was answered at the end
                self._undecided.remove(goal)
            if recalled:
                self._say(goal, Outcome.NOT_EXECUTED, OVERTAKEN)
                goal.handle.set_canceled(self._result(Outcome.NOT_EXECUTED, OVERTAKEN), OVERTAKEN)
            elif running is not None:
                todo = "Cancel it, or wait" if running.action.command is Command.GRIP else "Wait"
                why = f"{running.action.name} is still running: one goal at a time. {todo} for its end."
                self._refuse(goal, Outcome.REJECTED, why)
            elif not reply.accepted:
                self._refuse(goal, Outcome.REJECTED if reply.reached else Outcome.UNREACHABLE, reply.reason)
            else:
                goal.count = reply.count
                goal.handle.set_accepted()
                self._running = goal
        self._follow()

    def _ask(self, goal: _Goal) -> Reply:
        silent_us, answer = self._silent.get(goal.node, (0, None))
        if answer is not None and goal.came_us <= silent_us:
            return answer
        newest = self._newest.get(goal.node)
        goal.since_us, goal.asked = newest.since_us if newest is not None else 0, True
        reply = self._commanders[goal.node].ask(goal.action.command)
        if not reply.reached:
            self._silent[goal.node] = now_us(), reply
        return reply

    def _cancel(self, handle: Any) -> None:
        running = self._running
        if running is not None and running.handle == handle and running.action.command is Command.GRIP:
            # refused where nothing is to be unwound: the goal then ends as it would have
            self._commanders[GRIP].ask(Command.CANCEL)

    # In any thread.

    def _follow(self) -> None:
        running = self._running
        if running is None:
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

    def _say(self, goal: _Goal, outcome: int, reason: str) -> None:
        self._log.info("%s: %s", goal.action.name, f"{constant_name(Outcome(), outcome)}. {reason}".rstrip())

    def _refuse(self, goal: _Goal, outcome: int, reason: str) -> None:
        self._say(goal, outcome, reason)
        goal.handle.set_rejected(self._result(outcome, reason), reason)

    def _end(self, running: _Goal, outcome: int, reason: str) -> None:
        with self._lock:
            if self._running is not running:
                return
            self._running = None
        result, handle = self._result(outcome, reason), running.handle
        result.seconds = (now_us() - running.came_us) / 1e6
        if running.action.command is Command.GRIP:
            result.steps = self._state().steps
        self._say(running, outcome, reason)
        ends = {Outcome.SUCCEEDED: handle.set_succeeded, Outcome.CANCELLED: handle.set_canceled}
        ends.get(outcome, handle.set_aborted)(result, reason)

    def _result(self, outcome: int, reason: str) -> Any:
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
