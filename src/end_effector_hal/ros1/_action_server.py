"""An action server that leaves the decision about a second goal to its owner, and does not wait for Nagle."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import actionlib
import rospy

from ._node import message_class
from ._table import Action


def action_server(action: Action, on_goal: Callable[[Any], None], on_cancel: Callable[[Any], None]) -> Any:
    """A started server. ``SimpleActionServer`` would preempt a running goal in silence."""
    server = actionlib.ActionServer(
        action.name, message_class(action.type + "Action"), on_goal, on_cancel, auto_start=False
    )
    # rospy keeps one connection per topic: what is said of it first holds for the server's own use
    name = rospy.remap_name(action.name)  # as the server does: a remap names the action, not its topics
    for part, kind in (("result", server.ActionResult), ("feedback", server.ActionFeedback)):
        rospy.Publisher(f"{name}/{part}", kind, tcp_nodelay=True, queue_size=50)
    rospy.Subscriber(f"{name}/goal", server.ActionGoal, tcp_nodelay=True)
    server.start()
    return server
