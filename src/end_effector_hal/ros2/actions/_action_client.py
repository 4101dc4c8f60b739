"""The client of one action."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from action_msgs.msg import GoalStatus
from action_msgs.srv import CancelGoal
from rclpy.action import ActionClient
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node

from end_effector_hal.nodes.interface import Action
from end_effector_hal.nodes.transport import GoalMessage
from end_effector_hal.ros2.connections import RclpyMessageMaker, action_class


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
