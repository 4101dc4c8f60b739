"""ROS on this machine: which generation is sourced, and what it needs."""

from ._ros import look_at_ros
