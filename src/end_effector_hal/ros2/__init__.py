"""Run the nodes in ROS 2: their start, communication and end."""

from ._run import PROGRAMS, ROS_PACKAGES, main
from ._transports import without_shared_memory
