"""What differs between the generations of ROS: the rows of the table in ``docs/reference/ros2.md``, by name.

A check whose expectation differs names the row that allows it; a row that no check names is a fault (`test_list`).
"""

from __future__ import annotations

from enum import Enum


class Difference(Enum):
    """The first cell of a row."""

    REFUSED_GOAL = "a goal that is refused"
    CANCELLED_STATUS = "the status of a goal that was cancelled"
    CANCEL_OF_RELEASE = "a cancel of Drop, LockToolChanger, UnlockToolChanger while they run"
    CANCEL_BY_TIME = "a cancel by time that overtakes its goal"
    LOST_GOAL = "a goal of a HALMain that was killed"
    GRIPPER_CMD = "`gripper_cmd`"
    PROCESSES = "processes of the HAL"
    SAME_NAME = "a second node of one name"
    PARAMETERS = "parameters"
    LEVEL = "level in `/diagnostics`"
