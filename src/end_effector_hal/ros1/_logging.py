"""Logs of the core, in ROS's way: to the console and to /rosout."""

from __future__ import annotations

import logging

import rospy

_LEVELS = (
    (logging.ERROR, rospy.logerr),
    (logging.WARNING, rospy.logwarn),
    (logging.INFO, rospy.loginfo),
    (logging.DEBUG, rospy.logdebug),
)


class _ToRos(logging.Handler):
    def emit(self, record: logging.LogRecord) -> None:
        text = self.format(record)
        for level, log in _LEVELS:
            if record.levelno >= level:
                log("%s", text)
                return


def node_logger(node: str) -> logging.Logger:
    """The node's logger. Call it after ``init_node``, which replaces the handlers of the root logger."""
    top = logging.getLogger("end_effector_hal")
    top.propagate = False
    top.setLevel(logging.INFO)
    top.handlers = [_ToRos()]
    return logging.getLogger(f"end_effector_hal.{node}")
