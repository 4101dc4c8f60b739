"""Actions in ROS 1: their servers and their clients; only nodes with actions load actionlib."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any

from end_effector_hal.control.goals import Ending
from end_effector_hal.nodes.interface import Action
from end_effector_hal.nodes.transport import ActionClient, ActionServer, ClientGoal


def action_server(
    action: Action,
    on_goal: Callable[[ClientGoal], None],
    on_cancel: Callable[[ClientGoal], bool],
    result: Callable[[Ending], Any],
    log: logging.Logger,
) -> ActionServer:
    """Serve an action; see `NodeTransport.action_server`."""
    from ._action_server import GoalServer
    from ._later import Later

    server = GoalServer(action, on_goal, on_cancel, result, Later(log))
    server.start()
    return server


def action_client(action: Action) -> ActionClient:
    """Return a client of an action; see `NodeTransport.action_client`."""
    from ._action_client import GoalSender

    return GoalSender(action)
