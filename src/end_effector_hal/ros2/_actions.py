"""The client and the server of one action in ROS 2: rclpy's, with a limit for open goals and a reason for every end."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable
from typing import Any

from action_msgs.msg import GoalStatus
from action_msgs.srv import CancelGoal
from rclpy.action import ActionClient, ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.task import Future

from end_effector_hal.control.goals import Ending, Outcome
from end_effector_hal.nodes.interface import Action
from end_effector_hal.nodes.transport import ClientGoal, GoalMessage

from ._messages import RclpyMessageMaker, action_class


class RclpyActionClient:
    """Sends goals.

    Args:
        node: a node of rclpy; its executor runs in a thread.
        action: its name and type.
    """

    def __init__(self, node: Node, action: Action) -> None:
        self._node = node
        kind, group = action_class(action.type), ReentrantCallbackGroup()
        self._make = RclpyMessageMaker(kind.Goal, node.get_clock())
        self._client = ActionClient(node, kind, action.name, callback_group=group)
        self._cancels = node.create_client(
            CancelGoal, f"{action.name}/_action/cancel_goal", callback_group=group
        )

    def is_ready(self) -> bool:
        """Return whether the server is in the graph."""
        return bool(self._client.server_is_ready())

    def send(
        self, goal: GoalMessage, on_feedback: Callable[[Any], None], on_end: Callable[[Any, bool], None]
    ) -> None:
        """Send a goal; a refusal without a result does not come from our server, and the goal counts as lost."""

        def answered(future: Any) -> None:
            handle = future.result()
            if handle is None or not handle.accepted:
                on_end(None, False)
            else:
                handle.get_result_async().add_done_callback(ended)

        def ended(future: Any) -> None:
            response = future.result()
            on_end(response.result, response.status == GoalStatus.STATUS_SUCCEEDED)

        def send() -> None:
            sent = self._client.send_goal_async(
                self._make(goal), lambda message: on_feedback(message.feedback)
            )
            sent.add_done_callback(answered)

        # rclpy drops an answer that comes before it has noted the goal: both happen in one thread
        if (executor := self._node.executor) is not None:
            executor.create_task(send)

    def cancel_all(self) -> None:
        """Cancel every goal of this action, with a request that has neither an id nor a time."""
        self._cancels.call_async(CancelGoal.Request())


OPEN = 10
"""Maximum number of open goals of one action."""
RESULT_KEPT_S = 10
"""Time for which a result is kept for a client that requests it late, s."""


class RclpyActionServer:
    """Passes on goals and cancels of one action; it does not decide on them.

    A refusal of ROS 2 carries no text. So the server accepts every goal, and a rejected one ends ABORTED with the
    outcome REJECTED and the reason. A cancel that would have no effect is refused. All calls of rclpy are made in the
    executor's thread.

    Args:
        node: a node of rclpy; its executor runs in a thread.
        action: its name and type.
        on_goal, on_cancel: called with a goal, in the executor's thread.
        result: makes the result of a goal that this server refuses.
        log: logs failures.
    """

    def __init__(
        self,
        node: Node,
        action: Action,
        on_goal: Callable[[ClientGoal], None],
        on_cancel: Callable[[ClientGoal], bool],
        result: Callable[[Ending], Any],
        log: logging.Logger,
    ) -> None:
        kind = action_class(action.type)
        self._node, self._name, self._log = node, action.name, log
        self._on_goal, self._on_cancel, self._result = on_goal, on_cancel, result
        self.make_result = RclpyMessageMaker(kind.Result, node.get_clock())
        self.make_feedback = RclpyMessageMaker(kind.Feedback, node.get_clock())
        self._open: dict[bytes, RclpyGoal] = {}
        self._jobs: deque[Callable[[], None]] = deque()
        self._server = ActionServer(
            node,
            kind,
            action.name,
            execute_callback=_never,
            callback_group=ReentrantCallbackGroup(),
            goal_callback=lambda _goal: GoalResponse.ACCEPT,
            handle_accepted_callback=self._accepted,
            cancel_callback=self._cancelled,
            result_timeout=RESULT_KEPT_S,
        )

    def run(self, job: Callable[[], None]) -> None:
        """Run a job in the executor's thread, after the earlier ones; an exception is logged."""
        self._jobs.append(job)  # an executor does not keep the order of its tasks
        if (executor := self._node.executor) is not None:
            executor.create_task(self._work)

    def forget(self, goal: RclpyGoal) -> None:
        """Remove a goal that has ended."""
        self._open.pop(goal.key, None)

    def close(self) -> None:
        """Do nothing: results do not wait here, the executor sends them as soon as it can."""

    def _work(self) -> None:
        while self._jobs:
            try:
                self._jobs.popleft()()
            except Exception:  # noqa: BLE001 what escapes here ends the executor
                self._log.exception("%s: an answer could not be given", self._name)

    def _accepted(self, handle: ServerGoalHandle) -> None:
        goal = RclpyGoal(self, handle)
        if len(self._open) >= OPEN:
            why = f"{OPEN} goals of {self._name} wait for their answer: no more are accepted. Wait for their end."
            ending = Ending(Outcome.REJECTED, why)
            goal.end(ending, self._result(ending))
            return
        self._open[goal.key] = goal
        try:
            self._on_goal(goal)
        except Exception:  # noqa: BLE001 what escapes here ends the executor
            self._log.exception("%s: a goal could not be accepted", self._name)

    def _cancelled(self, handle: ServerGoalHandle) -> CancelResponse:
        goal = self._open.get(bytes(handle.goal_id.uuid))
        try:
            taken = goal is not None and self._on_cancel(goal)
        except Exception:  # noqa: BLE001 what escapes here ends the executor
            self._log.exception("%s: a cancel could not be accepted", self._name)
            taken = False
        return CancelResponse.ACCEPT if taken else CancelResponse.REJECT


class RclpyGoal:
    """A goal of a client, with its handle in rclpy."""

    def __init__(self, server: RclpyActionServer, handle: ServerGoalHandle) -> None:
        self._server, self._handle = server, handle
        self.key = bytes(handle.goal_id.uuid)
        self.over: Future = Future()

    @property
    def request(self) -> Any:
        """The goal message."""
        return self._handle.request

    def begin(self) -> None:
        """Set the goal to EXECUTING."""
        self._server.run(lambda: self._handle.execute(self._wait))

    def publish_feedback(self, feedback: Any) -> None:
        """Publish the progress of the goal."""
        message = self._server.make_feedback(feedback)
        self._server.run(lambda: self._handle.publish_feedback(message))

    def end(self, ending: Ending, result: Any) -> None:
        """Set the goal to SUCCEEDED, CANCELED or ABORTED."""
        message = self._server.make_result(result)
        wanted = (Outcome.CANCELLED, Outcome.NOT_EXECUTED)

        def end() -> None:
            if ending.seconds is None:
                # from ACCEPTED there is no way to an end but through EXECUTING
                self._handle.execute(self._wait)
            if ending.outcome is Outcome.SUCCEEDED:
                self._handle.succeed()
            elif ending.outcome in wanted and self._handle.is_cancel_requested:
                self._handle.canceled()
            else:
                self._handle.abort()
            self.over.set_result(message)
            self._server.forget(self)

        self._server.run(end)

    async def _wait(self, _handle: ServerGoalHandle) -> Any:
        # anything but a result ends the process in a failed assertion of C
        return await self.over


def _never(_handle: ServerGoalHandle) -> None:
    """Replace the callback that rclpy would call for every goal; each goal has its own callback instead."""
