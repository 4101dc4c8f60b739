"""Start the executables of the ROS package: an error is printed as one sentence, and the exit code shows its kind."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Sequence
from types import ModuleType
from typing import Any

from end_effector_hal.errors import RosError, UsageError
from end_effector_hal.nodes.process import guarded
from end_effector_hal.nodes.start import PROGRAMS, start_node

_ROS_PACKAGES = ("genpy", "rospy", "actionlib", "diagnostic_msgs", "sensor_msgs", "std_msgs", "std_srvs")


LINE_ARBITER = "line_arbiter"


def main(argv: Sequence[str]) -> int:
    """Run the program that the first argument names, a node or the line arbiter; return the exit code."""
    program = argv[0]
    if program == LINE_ARBITER:
        return guarded(program, lambda: _run_arbiter(argv))
    return guarded(program, lambda: _run_node(program, argv))


def _run_node(program: str, argv: Sequence[str]) -> int:
    if program not in PROGRAMS:
        raise UsageError("There is no such program in ROS 1.", todo=f"There are {', '.join(PROGRAMS)}.")
    name = PROGRAMS[program]
    try:
        _import_ros()
        from ._ros_node import RosNode

        with RosNode(name, argv) as node:
            code = start_node(name, node)
            if code is None:
                return node.spin()
            node.end()
            return code
    except ModuleNotFoundError as error:
        raise _missing(error) from None


def _run_arbiter(argv: Sequence[str]) -> None:
    """Run the line arbiter as ``eehal arbiter`` does, with the arguments of a node; it needs no master."""
    from end_effector_hal.arbiter import run_arbiter
    from end_effector_hal.codecs import load_tool

    from ._name_taken import tool_named

    run_arbiter(load_tool(tool_named(argv, lambda _: "")))


def _import_ros() -> None:
    """Import the messages and rospy without libraries that no node uses, which saves 0.3 s and 20 MB for each node.

    genpy needs numpy only for its number types. rospy needs roslib only to detect an interactive prompt, and roslib
    imports catkin_pkg and pyparsing. The master and the nodes use plain HTTP, for which ``xmlrpc`` needs no ssl; its
    server uses pydoc only for a class that shows the methods as a page.
    """
    pydoc: Any = ModuleType("pydoc")
    pydoc.HTMLDoc = object
    roslib: Any = ModuleType("roslib")
    roslib.is_interactive = lambda: False
    stand_ins = {"numpy": None, "pydoc": pydoc, "roslib": roslib, "ssl": None}
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
