"""The check that a launch file of either ROS runs before it starts anything."""

from ._launch_check import check_launch
