"""Run the nodes in ROS 1: their start, communication and end."""

from ._run import main
