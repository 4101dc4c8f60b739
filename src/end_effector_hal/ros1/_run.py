"""How the executables of the ROS package start: an error is one sentence, and the exit code says its kind."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

from end_effector_hal.errors import RosError
from end_effector_hal.nodes import start_node
from end_effector_hal.nodes.process import guarded

_ROS_PACKAGES = ("genpy", "rospy", "actionlib", "diagnostic_msgs", "sensor_msgs", "std_msgs", "std_srvs")


def run(name: str) -> None:
    """Run a node of the table, and exit with its code."""
    sys.exit(guarded(Path(sys.argv[0]).name, lambda: _run_node(name)))


def _run_node(name: str) -> int:
    try:
        _import_ros()
        from ._ros_node import RosNode

        with RosNode(name, sys.argv) as node:
            code = start_node(name, node)
            if code is None:
                return node.spin()
            node.end()
            return code
    except ModuleNotFoundError as error:
        raise _missing(error) from None


def run_line_owner() -> None:
    """Run the line arbiter as ``eehal arbiter`` does, with the arguments of a node; it needs no master."""
    from end_effector_hal.codecs import load_tool
    from end_effector_hal.runtime import run_arbiter

    from ._tool_named import tool_named

    sys.exit(guarded("line_owner", lambda: run_arbiter(load_tool(tool_named(sys.argv, lambda _: "")))))


def check_launch(argv: Sequence[str]) -> int:
    """The check of the launch file before it starts anything; see `_launch_check`. Returns the exit code."""
    from ._launch_check import launch_check

    return guarded("end_effector.launch", lambda: launch_check(argv))


def _import_ros() -> None:
    """Import the messages and rospy without two libraries that no node uses: 0.3 s and 18 MB less for each node.

    genpy asks numpy only for its number types; catkin_pkg has pyparsing for conditions in a ``package.xml``.
    """
    pyparsing: Any = ModuleType("pyparsing")
    pyparsing.infixNotation = None
    stand_ins = {"numpy": None, "pyparsing": pyparsing}
    absent = [name for name in stand_ins if name not in sys.modules]
    sys.modules.update({name: stand_ins[name] for name in absent})
    try:
        for name in ("end_effector_msgs.msg", "rospy"):
            importlib.import_module(name)
    finally:
        for name in absent:
            del sys.modules[name]


def _missing(error: ModuleNotFoundError) -> Exception:
    package = (error.name or "").partition(".")[0]
    if package == "end_effector_msgs":
        return RosError(
            "The ROS messages are not built, or not sourced.",
            todo="Run ros/build.sh, then . build/catkin/devel/setup.sh",
        )
    if package in _ROS_PACKAGES:
        return RosError(
            f"The Python package {package} of ROS is missing.",
            todo="Install Debian's ROS packages; make the environment with --system-site-packages.",
        )
    return error
