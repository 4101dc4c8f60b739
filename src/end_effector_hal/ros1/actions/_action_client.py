"""The client of one action in ROS 1."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus

from end_effector_hal.nodes.interface import Action
from end_effector_hal.nodes.transport import GoalMessage
from end_effector_hal.ros1.connections import MessageMaker, encodable, message_class

_SOON = rospy.Duration(0, 1_000_000)


class GoalSender:
    """Sends goals."""

    def __init__(self, action: Action) -> None:
        self._make = MessageMaker(message_class(f"{action.type}Goal"))
        self._client = actionlib.ActionClient(action.name, message_class(f"{action.type}Action"))
        self._handles: list[Any] = []
        """Handles of the sent goals; they are kept because actionlib's manager holds goals only weakly."""

    def is_ready(self) -> bool:
        """Return whether the server is connected."""
        return bool(self._client.wait_for_server(_SOON))

    def send(
        self, goal: GoalMessage, on_feedback: Callable[[Any], None], on_end: Callable[[Any, bool], None]
    ) -> None:
        """Send a goal; a goal that actionlib's client reports as LOST does not count as ended."""
        once = threading.Lock()

        def moved(handle: Any) -> None:
            if handle.get_comm_state() == actionlib.CommState.DONE and once.acquire(blocking=False):
                on_end(handle.get_result(), handle.get_goal_status() == GoalStatus.SUCCEEDED)

        handle = self._client.send_goal(
            encodable(self._make(goal)), moved, lambda _handle, feedback: on_feedback(feedback)
        )
        self._handles.append(handle)

    def cancel_all(self) -> None:
        """Cancel every goal of this action."""
        self._client.cancel_all_goals()
