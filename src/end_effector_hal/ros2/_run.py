"""Start the executables of the ROS 2 package: an error is printed as one sentence, and the exit code shows its kind."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing

from end_effector_hal.errors import RosError, UsageError
from end_effector_hal.nodes.interface import HAL_NODES
from end_effector_hal.nodes.process import guarded
from end_effector_hal.nodes.start import PROGRAMS as NODE_PROGRAMS
from end_effector_hal.nodes.start import start_node

ROS_PACKAGES = (
    "rclpy",
    "action_msgs",
    "builtin_interfaces",
    "diagnostic_msgs",
    "lifecycle_msgs",
    "rcl_interfaces",
    "sensor_msgs",
    "std_msgs",
    "std_srvs",
)
"""Packages of ROS 2 that the nodes import."""


MANAGED = "lifecycle_hal"
PROGRAMS = {
    "hal": HAL_NODES,
    MANAGED: HAL_NODES,
    **{program: (node,) for program, node in NODE_PROGRAMS.items()},
}
"""The executables and their nodes: HALMain starts first, because it runs the tool of the others, and ends last.

The nodes of `MANAGED` work while its lifecycle node is active.
"""
CHECK_LAUNCH = "check_launch"


def main(argv: Sequence[str]) -> int:
    """Run the nodes of an executable in one process, or the check of the launch file; return the exit code.

    Args:
        argv: the name of the executable, then its arguments.
    """
    if argv and argv[0] == CHECK_LAUNCH:
        from end_effector_hal.nodes.launching import check_launch

        return check_launch(argv[1:], "ros2 launch")
    if argv and argv[0] in PROGRAMS:
        return guarded(argv[0], lambda: _run(argv[0], argv))
    return guarded("ros2", lambda: _unknown(argv))


def _run(program: str, argv: Sequence[str]) -> int:
    try:
        return _run_managed(argv) if program == MANAGED else _run_nodes(PROGRAMS[program], argv)
    except ModuleNotFoundError as error:
        raise _missing(error) from None


def _run_nodes(names: Sequence[str], argv: Sequence[str]) -> int:
    from ._process import NodeGroup, Process
    from ._ros_node import RclpyNode

    with closing(Process(argv)) as process, closing(NodeGroup(process, names)) as group:
        # a name that is taken is found before the tool is opened
        nodes = {name: RclpyNode(name, group) for name in names}
        code = None
        for name, node in nodes.items():
            code = start_node(name, node)
        group.start()
        return process.wait() if code is None else code


def _run_managed(argv: Sequence[str]) -> int:
    from ._lifecycle import ToolLifecycle
    from ._process import Process

    with (
        closing(Process(argv)) as process,
        closing(ToolLifecycle(process, PROGRAMS[MANAGED], argv)),
    ):
        return process.wait()


def _unknown(argv: Sequence[str]) -> int:
    what = f"{argv[0]!r} is no program." if argv else "No program is named."
    raise UsageError(what, todo=f"There are {', '.join(PROGRAMS)}.")


def _missing(error: ModuleNotFoundError) -> Exception:
    package = (error.name or "").partition(".")[0]
    if package in ("end_effector_msgs", "genpy"):
        return RosError(
            "The messages of ROS 2 are not built, or those of ROS 1 come before them in PYTHONPATH.",
            todo="Source one ROS only; in the checkout: make ros2.",
        )
    if package in ROS_PACKAGES:
        return RosError(
            f"The Python package {package} of ROS 2 is missing.",
            todo="Source ROS 2, such as: . /opt/ros/jazzy/setup.bash",
        )
    return error
