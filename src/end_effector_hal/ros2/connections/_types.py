"""The classes of ROS 2 for the types of the table."""

from __future__ import annotations

from functools import partial

from end_effector_hal.nodes.process import has_ros_class, ros_class

_TODO = "Build the workspace with colcon and source its install/setup.bash; in the checkout: make ros2."

message_class = partial(ros_class, kind="msg", todo=_TODO)
service_class = partial(ros_class, kind="srv", todo=_TODO)
has_action_class = partial(has_ros_class, kind="action")
action_class = partial(ros_class, kind="action", todo=_TODO)
