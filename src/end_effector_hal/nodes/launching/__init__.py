"""What a launch file of either ROS asks before it starts anything."""

from ._launch_check import check_launch
