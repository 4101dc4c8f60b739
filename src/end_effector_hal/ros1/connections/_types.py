"""The classes of ROS 1 for the types of the table."""

from __future__ import annotations

from functools import partial

from end_effector_hal.nodes.process import ros_class

_TODO = "Run ros/build.sh, then . build/catkin/devel/setup.sh"

message_class = partial(ros_class, kind="msg", todo=_TODO)
service_class = partial(ros_class, kind="srv", todo=_TODO)
