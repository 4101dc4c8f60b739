"""The log of a node in ROS 1: to the console and to /rosout."""

from __future__ import annotations

import logging

import rospy

_LEVELS = (
    (logging.ERROR, rospy.logerr),
    (logging.WARNING, rospy.logwarn),
    (logging.INFO, rospy.loginfo),
    (logging.DEBUG, rospy.logdebug),
)


def write_line(level: int, text: str) -> None:
    """Write a text at a level of `logging`, with the name of this node: the console shows none."""
    log = next((log for least, log in _LEVELS if level >= least), rospy.logdebug)
    log("%s", f"{rospy.get_name()}: {text}")
