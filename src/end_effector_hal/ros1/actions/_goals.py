"""Goals to the four actions, and how each ended, in words."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from end_effector_msgs.msg import EndEffectorAction, EndEffectorGoal

from end_effector_hal.control.goals import Outcome
from end_effector_hal.errors import RosError
from end_effector_hal.nodes.interface import ACTIONS, GIVE_UP_S, PATIENCE_S
from end_effector_hal.vocabulary import Command, EndEffectorState

_SILENT_S = 2.0
"""HALMain lists its goals 5 times a second: after this it is said that it is waited for."""

_OUTCOMES = {each.value: each.name for each in Outcome}


class ActionGoal:
    """One goal that was sent; ``succeeded`` is None until it has ended."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.succeeded: bool | None = None
        self.handle: Any = None
        self.ended = threading.Event()
        self._shown: tuple[int, str, int] | None = None

    def fed(self, feedback: Any) -> str:
        """What is new in a feedback, in words; empty: nothing."""
        shown = (feedback.state, feedback.actuator, feedback.attempt)
        if shown == self._shown:
            return ""
        self._shown = shown
        step = f", {feedback.actuator}" if feedback.actuator else ""
        attempt = (
            f", attempt {feedback.attempt} of {feedback.attempts_allowed}" if feedback.attempt > 1 else ""
        )
        return f"{self.name}: {EndEffectorState(feedback.state).name}{step}{attempt}"

    def end(self) -> str:
        """Take the result; returns it in words."""
        result, status = self.handle.get_result(), self.handle.get_goal_status()
        if result is None:  # actionlib's client calls it LOST
            return self.lose("HALMain was started again and does not know this goal")
        outcome = _OUTCOMES.get(result.outcome, "FAILED")
        self.succeeded = status == GoalStatus.SUCCEEDED and outcome == "SUCCEEDED"
        reason = result.reason or self.handle.get_goal_status_text()
        if status in (GoalStatus.REJECTED, GoalStatus.RECALLED):
            return f"{self.name}: {outcome}. {reason}".rstrip()
        state = EndEffectorState(result.state).name
        steps = "; ".join(_step(step) for step in result.steps if step.attempts)
        tail = (f" {reason}" if reason and not self.succeeded else "") + (f" [{steps}]" if steps else "")
        return f"{self.name}: {outcome} after {result.seconds:.2f} s, the end-effector is {state}.{tail}"

    def lose(self, why: str) -> str:
        """Give it up; returns that in words."""
        self.succeeded = False
        return f"{self.name}: UNREACHABLE. {why}: what became of it is unknown, see EndEffectorState."

    def listed(self, message: Any) -> bool:
        """Whether a GoalStatusArray names it."""
        own = self.handle.comm_state_machine.action_goal.goal_id.id
        return any(status.goal_id.id == own for status in message.status_list)


class ActionClients:
    """Client of all actions.

    Args:
        say: takes each sentence; also called in threads of rospy.
        patience_s: a goal is given up when HALMain does not list it for so long.
    """

    def __init__(self, say: Callable[[str], None], patience_s: float = PATIENCE_S) -> None:
        self._say, self._patience_s = say, patience_s
        self._names = {Command(action.command): action.name for action in ACTIONS}
        self._clients = {
            Command(action.command): actionlib.ActionClient(action.name, EndEffectorAction)
            for action in ACTIONS
        }
        self._sent: list[ActionGoal] = []

    def wait_for_servers(self) -> None:
        """Wait until every action is up, with a message; raises RosError after 30 s."""
        if self._up(1.0):
            return
        self._say(f"waiting for the actions {', '.join(self._names.values())} …")
        if not self._up(GIVE_UP_S - 1.0) and not rospy.is_shutdown():
            raise RosError(
                f"The actions of HALMain did not come up within {GIVE_UP_S:g} s.",
                todo="Is the launch file running? See `rosnode list` and `rostopic list`.",
            )

    def send(self, command: Command) -> ActionGoal:
        """Send a goal; what becomes of it is said when it is known."""
        goal = ActionGoal(command.name.lower())
        self._sent.append(goal)
        lock = threading.Lock()

        def moved(handle: Any) -> None:
            with lock:
                goal.handle = handle
                if handle.get_comm_state() == actionlib.CommState.DONE and not goal.ended.is_set():
                    self._say(goal.end())
                    goal.ended.set()  # not before it is said: whoever waits goes on at once, perhaps to its end

        def fed(_handle: Any, feedback: Any) -> None:
            if text := goal.fed(feedback):
                self._say(text)

        # the manager of actionlib keeps goals weakly
        goal.handle = self._clients[command].send_goal(EndEffectorGoal(), moved, fed)
        return goal

    def wait(self, goal: ActionGoal) -> None:
        """Wait until a goal has ended, or HALMain has not listed it for too long: it has gone, or hangs."""
        client = self._clients[Command[goal.name.upper()]]
        newest, since, said = None, time.monotonic(), False
        while not goal.ended.wait(0.1) and not rospy.is_shutdown():
            before, newest = newest, client.last_status_msg
            if newest is not None and newest is not before and goal.listed(newest):
                since, said = time.monotonic(), False
            silent_s = time.monotonic() - since
            if silent_s > self._patience_s:
                self._say(goal.lose(f"HALMain was silent for {self._patience_s:g} s"))
                goal.ended.set()
            elif silent_s > _SILENT_S and not said:
                said = True
                self._say(f"{goal.name}: HALMain is silent; waiting for it, {self._patience_s:g} s at most …")

    @property
    def any_failed(self) -> bool:
        """Whether any goal has ended otherwise than in success."""
        return any(goal.succeeded is False for goal in self._sent)

    def cancel(self) -> bool:
        """Cancel whatever runs, whoever sent it; returns whether a goal of ours is running."""
        for client in self._clients.values():
            client.cancel_all_goals()
        return any(not goal.ended.is_set() for goal in self._sent)

    def wait_for_all(self) -> None:
        """Wait until none of our goals runs."""
        for goal in self._sent:
            self.wait(goal)

    def _up(self, timeout_s: float) -> bool:
        end = time.monotonic() + timeout_s
        return all(
            client.wait_for_server(rospy.Duration.from_sec(max(0.01, end - time.monotonic())))
            for client in self._clients.values()
        )


def _step(step: Any) -> str:
    attempts = f", attempt {step.attempts}" if step.attempts > 1 else ""
    return f"{step.actuator} {step.seconds:.2f} s{attempts}{'' if step.confirmed else ', not confirmed'}"
