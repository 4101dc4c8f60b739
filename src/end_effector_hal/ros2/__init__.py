"""The nodes in ROS 2: how they start, talk and end there."""

from ._run import MANAGED, PROGRAMS, ROS_PACKAGES, main
