"""Actions in ROS 1: their servers and their clients; only the nodes that have some load actionlib."""

from __future__ import annotations

import logging
from collections.abc import Callable

from end_effector_hal.nodes.transport import GoalClient, GoalService, StateMessage


def serve_goals(state: Callable[[], StateMessage], log: logging.Logger) -> GoalService:
    """Serve the four actions; ``state`` gives the latest state."""
    from ._served_goals import ServedGoals

    return ServedGoals(state, log)


def goal_client(say: Callable[[str], None], patience_s: float) -> GoalClient:
    """A client of the four actions; see `NodeTransport.goal_client`."""
    from ._goals import ActionClients

    return ActionClients(say, patience_s)
