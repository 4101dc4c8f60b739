"""The nodes in ROS 1: how they start, talk and end there."""

from ._run import main
