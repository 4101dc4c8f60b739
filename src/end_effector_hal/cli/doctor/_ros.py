"""Checks ROS on this machine: that one generation is sourced, then the needs of ROS 1 (those of ROS 2: `_ros2`)."""

from __future__ import annotations

import importlib
import os
import shutil
from pathlib import Path

from end_effector_hal.errors import RosError

from ._check_result import CheckedPart, CheckResult, CheckResults
from ._machine import is_importable
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


PACKAGES = (
    "rospy",
    "actionlib",
    "actionlib_msgs",
    "diagnostic_msgs",
    "sensor_msgs",
    "std_msgs",
    "std_srvs",
    "rospkg",
)
PROGRAMS = ("roscore", "roslaunch")
OURS = "end_effector_hal"
_BUILD = "ros/build.sh, then . build/catkin/devel/setup.sh"


def look_at_ros1() -> CheckResults:
    """Check ROS 1. ROS is only one of several interfaces: an absent part is MISSING only if ROS_MASTER_URI is set."""
    wanted = "ROS_MASTER_URI" in os.environ
    absent = [name for name in PACKAGES if not is_importable(name)]
    absent += [name for name in PROGRAMS if not shutil.which(name)]
    if absent:
        yield _absent(absent, wanted)
    else:
        yield _say.ok("ROS packages and programs are there")
    if is_importable("end_effector_msgs.msg"):
        yield _messages(wanted)
    elif not absent:
        yield _say.lacks(
            "the messages end_effector_msgs are not built, or not sourced", _BUILD, wanted=wanted
        )
    if wanted:
        yield from _look_at_master()
    else:
        yield _say.warning(
            "ROS_MASTER_URI is not set: no master is looked for",
            "Only the ROS nodes need one; source the workspace to use them.",
        )


def _absent(names: list[str], wanted: bool) -> CheckResult:
    text = f"not there: {', '.join(names)}"
    if Path("/usr/lib/python3/dist-packages/rospy").is_dir() and "rospy" in names:
        return _say.lacks(
            f"{text}; Debian's ROS is installed, and this environment does not see it",
            "Make it with /usr/bin/python3 -m venv --system-site-packages.",
            wanted=wanted,
        )
    return _say.lacks(
        text,
        "deploy/debian.sh installs ROS 1 on Debian 12; ROS 2 is sourced, such as . /opt/ros/jazzy/setup.bash; "
        "without ROS: eehal arbiter, EndEffector.open",
        wanted=wanted,
    )


def _messages(wanted: bool) -> CheckResult:
    """Check that roslaunch finds our package: a workspace that is sourced only in part gives Python its messages, but
    roslaunch no package.
    """
    built = "end_effector_msgs are built"
    try:
        rospkg = importlib.import_module("rospkg")
    except ImportError:
        return _say.ok(built)
    try:
        return _say.ok(f"{built}; roslaunch finds {rospkg.RosPack().get_path(OURS)}")
    except rospkg.ResourceNotFound:
        return _say.lacks(
            f"{built}; roslaunch does not find {OURS}",
            "Source the whole workspace; Debian's package ros-environment sets ROS_PACKAGE_PATH.",
            wanted=wanted,
        )


def _look_at_master() -> CheckResults:
    from end_effector_hal.ros1.master import ask_pid, master_uri

    try:
        uri, pid = master_uri(), ask_pid()
    except RosError as error:
        yield _say.missing(error.what, error.todo)
        return
    yield _say.ok(f"master at {uri} (pid {pid})")
    yield _nodes()


def _nodes() -> CheckResult:
    from end_effector_hal.nodes.interface import HAL_NODES

    try:
        answering = [name for name in _registered() if _answers(name)]
    except RosError as error:
        return _say.missing(error.what, error.todo)
    called = {name.rsplit("/", 1)[-1] for name in answering}
    absent = [name for name in HAL_NODES if name not in called]
    if not absent:
        return _say.ok(f"nodes {', '.join(HAL_NODES)} answer")
    todo = (
        "roslaunch end_effector_hal end_effector.launch description:=FILE; its output says why a node ends."
    )
    if len(absent) == len(HAL_NODES):
        return _say.missing("none of the HAL's nodes runs", todo)
    return _say.missing(f"nodes that do not answer: {', '.join(absent)}", todo)


def _registered() -> list[str]:
    """Return all nodes that publish a topic."""
    from end_effector_hal.ros1.master import ask_master

    publishers, *_ = ask_master("getSystemState")
    return sorted({node for _, nodes in publishers for node in nodes})


def _answers(name: str) -> bool:
    """Return whether a node answers, asked as by ``rosnode ping``: a killed node stays registered."""
    from end_effector_hal.ros1.master import NoSuchMethod, ask_master, ask_node

    try:
        return isinstance(ask_node(str(ask_master("lookupNode", name)), "getPid"), int)
    except (RosError, OSError, NoSuchMethod):
        return False
