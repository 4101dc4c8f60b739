"""Checks that only one generation of ROS is sourced, then the needs of this generation."""

from __future__ import annotations

import os
from pathlib import Path

from end_effector_hal.cli.doctor._check_result import CheckedPart, CheckResults

from ._importable import is_importable
from ._ros1 import look_at_ros1
from ._ros2 import look_at_ros2

_CLIENT_LIBRARY = {"ROS 1": "rospy", "ROS 2": "rclpy"}
_MESSAGES = {"ROS 1": "_EndEffectorState.py", "ROS 2": "_end_effector_state.py"}
"""File name of the Python module that each generation's generator makes from one of our messages."""
_say = CheckedPart("ros")


def look_at_ros() -> CheckResults:
    """Check ROS 2 if it is sourced or the only one, else ROS 1."""
    folders = {name: _folder_of(name) for name in _CLIENT_LIBRARY}
    if all(folders.values()):
        named = " and ".join(f"{name} ({folder})" for name, folder in folders.items())
        yield _say.missing(
            f"PYTHONPATH names {named}: their packages have the same names",
            "Source one of them only, in a new terminal; each needs an environment of its own.",
        )
    yield from look_at_ros2() if _ros2_is_meant() else look_at_ros1()


def _ros2_is_meant() -> bool:
    if version := os.environ.get("ROS_VERSION"):
        return version == "2"
    if "ROS_MASTER_URI" in os.environ:
        return False
    return "AMENT_PREFIX_PATH" in os.environ or (is_importable("rclpy") and not is_importable("rospy"))


def _folder_of(generation: str) -> str:
    """Return the first folder of PYTHONPATH that belongs to a generation of ROS; "" if there is none."""
    for folder in filter(None, os.environ.get("PYTHONPATH", "").split(":")):
        messages = Path(folder, "end_effector_msgs", "msg", _MESSAGES[generation])
        if Path(folder, _CLIENT_LIBRARY[generation]).is_dir() or messages.is_file():
            return folder
    return ""
