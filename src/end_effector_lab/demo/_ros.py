"""Drives the tool on ROS 1 or ROS 2 with nodes of its own, and the Supervisor.

This module only starts processes and reads the recording; it imports nothing of ROS.
"""

from __future__ import annotations

import importlib.util
import os
import random
import shutil
import signal
import socket
import sys
from collections import deque
from collections.abc import Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path

from end_effector_hal.errors import RosError
from end_effector_lab.processes import Child, Children

from ._world import START_S, World, give_recorded

END_S = 20.0
LOOPBACK = "127.0.0.1"
LAUNCH = ("roslaunch", "--wait", "end_effector_hal", "end_effector.launch", "arbiter:=false")
RUN = ("rosrun", "end_effector_hal")
PROGRAMS = ("roscore", "roslaunch", "rosrun")
DEBIAN = (
    "python3-rospy python3-actionlib python3-roslaunch python3-rostopic python3-diagnostic-msgs "
    "python3-sensor-msgs python3-std-srvs rosbash catkin ros-message-generation"
)
WITHOUT = "Without ROS: `eehal demo --no-ros`."


class Ros1:
    """Drives the tool with the nodes of the launch file and the actions of HALMain; DataLogger records."""

    ros = 1

    def check(self) -> None:
        """Raise RosError with the remedy if ROS or its messages are missing."""
        missing = [name for name in PROGRAMS if shutil.which(name) is None]
        missing += [] if importlib.util.find_spec("rospy") else ["rospy"]
        if missing:
            raise RosError(
                f"ROS is not installed: {', '.join(missing)} not found.",
                todo=f"On Debian 12: `make setup`, or `apt install {DEBIAN}`. {WITHOUT}",
            )
        if importlib.util.find_spec("end_effector_msgs") is None:
            raise RosError(
                "The ROS messages are not built, or not sourced.",
                todo=f"Run `make demo`, or ros/build.sh and then `. build/catkin/devel/setup.sh`. {WITHOUT}",
            )

    def play(self, world: World, script: str, longest_s: float) -> None:
        folder, description = world.folder, str(world.description_path.absolute())
        ros = Master(folder / "ros")
        master = ros.start(world.children, folder / "roscore.log", patience_s=START_S)
        launch = start_nodes(world, ros.env, f"trace_directory:={folder.absolute()}")
        start = partial(world.children.start, failed=RosError, env=ros.env)
        # not by the launch file: it is to end before the nodes do, so that their end is not recorded as a state
        logger = [*RUN, "data_logger", f"_description:={description}", f"_directory:={folder.absolute()}"]
        supervisor = [*RUN, "supervisor", f"_script:={script}"]
        give_recorded(world, launch, start, logger, supervisor, longest_s)
        world.children.end_since(master)


def start_nodes(world: World, env: Mapping[str, str], *arguments: str) -> Child:
    """Start the launch file on a world whose line arbiter already runs."""
    return world.children.start(
        "launch file",
        [*LAUNCH, f"description:={world.description_path.absolute()}", *arguments],
        log=world.folder / "roslaunch.log", failed=RosError, env=env, end_by=signal.SIGINT, patience_s=END_S,
    )  # fmt: skip


class Master:
    """A ROS master on a free loopback port, so that other ROS programs on this machine are not affected.

    Args:
        logs: a folder for the logs of ROS; it is made.

    Attributes:
        env: environment variables for its nodes.
    """

    def __init__(self, logs: Path) -> None:
        logs.mkdir(parents=True, exist_ok=True)
        # two that begin at once would both make it, and one of them would end
        Path(os.environ.get("ROS_HOME") or Path.home() / ".ros").mkdir(parents=True, exist_ok=True)
        self._port = free_port()
        self.env = {
            "ROS_MASTER_URI": f"http://{LOOPBACK}:{self._port}",
            "ROS_IP": LOOPBACK,
            "ROS_LOG_DIR": str(logs.absolute()),
            "PYTHONUNBUFFERED": "1",
            # the nodes ask `env` for python3: it is to be this one
            "PATH": f"{Path(sys.executable).parent}:{os.environ.get('PATH', os.defpath)}",
        }

    def start(self, children: Children, log: Path, *, patience_s: float) -> Child:
        """Start a roscore and wait until it answers.

        Raises:
            RosError: it did not answer within ``patience_s``; with the last lines of its log.
        """
        command = ["roscore", "-p", str(self._port)]
        child = children.start(
            "roscore", command, log=log, failed=RosError, env=self.env, end_by=signal.SIGINT
        )
        child.wait_until(self._answers, timeout_s=patience_s, what="it answered")
        return child

    def _answers(self) -> bool:
        with suppress(OSError), socket.create_connection((LOOPBACK, self._port), timeout=0.5):
            return True
        return False


def free_port() -> int:
    """Return a port of the loopback that is free now."""
    with socket.socket() as probe:
        probe.bind((LOOPBACK, 0))
        return int(probe.getsockname()[1])


END_S = 20.0
PROGRAM = (sys.executable, "-P", "-m", "end_effector_hal.ros2")
ONE, FIVE = ("hal",), ("pressure", "position", "grip", "tool_change", "hal_main")
MOST_DOMAIN = 101
"""Largest domain number; the ports of larger ones are among those that Linux assigns to other programs."""
_MOST_CLAIMS = 16


class Ros2:
    """Drives the tool with the nodes and the actions of HALMain; DataLogger records.

    Args:
        five: a process for each node, as the paper draws them.
    """

    ros = 2

    def __init__(self, *, five: bool = False) -> None:
        self._programs = FIVE if five else ONE

    def check(self) -> None:
        """Raise RosError with the remedy if ROS 2 or its messages are missing."""
        for package, todo in (
            ("rclpy", "Source ROS 2, such as `. /opt/ros/jazzy/setup.bash`, or run `make demo-ros2`."),
            ("end_effector_msgs", "Build the workspace with colcon and source its install/setup.bash."),
        ):
            if importlib.util.find_spec(package) is None:
                raise RosError(
                    f"The Python package {package} of ROS 2 is not here.",
                    todo=f"{todo} Without ROS: `eehal demo --no-ros`.",
                )

    def play(self, world: World, script: str, longest_s: float) -> None:
        folder = world.folder.absolute()
        start = partial(world.children.start, failed=RosError, env=apart(folder / "ros"))
        recorded = [
            "--ros-args",
            "-p", f"description:={world.description_path.absolute()}",
            "-p", f"directory:={folder}",
        ]  # fmt: skip
        nodes = [
            start(
                program, [*PROGRAM, program, *recorded], log=folder / f"{program}.log",
                end_by=signal.SIGINT, patience_s=END_S,
            )
            for program in self._programs
        ]  # fmt: skip
        supervisor = [*PROGRAM, "supervisor", "--ros-args", "-p", f"script:={script}"]
        give_recorded(world, nodes[0], start, [*PROGRAM, "data_logger", *recorded], supervisor, longest_s)
        world.children.end_since(nodes[0])


_claims: deque[int] = deque()
"""Sockets that claim domain numbers; they close with the process."""


def _free_domain() -> int:
    """Return a domain number that no other process of this machine has claimed here; the newest numbers stay claimed
    until this process ends.
    """
    if len(_claims) == _MOST_CLAIMS:
        os.close(_claims.popleft())
    numbers = list(range(1, MOST_DOMAIN + 1))
    random.SystemRandom().shuffle(numbers)
    for number in numbers:
        claim = socket.socket(socket.AF_UNIX)
        try:
            claim.bind(f"\0end-effector-hal/domain/{number}")  # an abstract name: it is gone with its process
        except OSError:
            claim.close()
            continue
        _claims.append(claim.detach())
        return number
    raise RosError("All domains of ROS 2 are in use by tools on this machine.", todo="End some of them.")


def apart(logs: Path) -> dict[str, str]:
    """Return the environment variables for processes of ROS 2 that communicate only with each other on this machine.

    Args:
        logs: folder for the logs of ROS.
    """
    return {
        "ROS_DOMAIN_ID": str(_free_domain()),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_LOG_DIR": str(logs),
        "PYTHONUNBUFFERED": "1",
    }
