"""Drives the tool on ROS 2 with one process of the HAL or five, and the Supervisor.

This module only starts processes and reads the recording; it imports nothing of ROS.
"""

from __future__ import annotations

import importlib.util
import os
import random
import signal
import socket
import sys
from collections import deque
from functools import partial
from pathlib import Path

from end_effector_hal.errors import RosError

from ._drive import give_recorded
from ._world import World

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
        "FASTDDS_BUILTIN_TRANSPORTS": "SHM",
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_LOG_DIR": str(logs),
        "PYTHONUNBUFFERED": "1",
    }
