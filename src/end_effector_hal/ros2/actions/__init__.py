"""Actions in ROS 2: their servers and their clients."""

from ._action_client import RclpyActionClient
from ._action_server import RclpyActionServer
