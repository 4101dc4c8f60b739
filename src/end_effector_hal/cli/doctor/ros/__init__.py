"""Checks ROS on this machine: which generation is sourced, and whether all that it needs is there."""

from ._ros import look_at_ros
