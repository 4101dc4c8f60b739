"""The environments of both ROS generations, used in separate processes; the benchmark itself needs neither."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from end_effector_hal.errors import RosError

ROOT = Path(__file__).parents[1]
SETUP = ROOT / "build/catkin/devel/setup.bash"
ROS2 = ROOT / "build/ros2/bin/python"


@dataclass(frozen=True)
class Environment:
    """An interpreter, and the additional environment variables of its processes."""

    python: str = sys.executable
    env: Mapping[str, str] = field(default_factory=dict)

    def with_env(self, more: Mapping[str, str]) -> Environment:
        """Return the same environment with more variables."""
        return Environment(self.python, {**self.env, **more})


def environment(part: str) -> Environment:
    """Return the environment of a part of the benchmark; raises RosError if it is missing."""
    if part == "ros":
        return Environment(env=_sourced())
    if part == "core":
        return Environment()
    if not ROS2.exists():
        raise RosError("There is no environment of ROS 2.", todo="make ros2")
    return Environment(str(ROS2))


def _sourced() -> dict[str, str]:
    if not SETUP.exists():
        raise RosError("The workspace of ROS 1 is not built.", todo="make setup")
    text = f'. "{SETUP}" && export PATH="{Path(sys.executable).parent}:$PATH" && env -0'
    done = subprocess.run(["bash", "-c", text], capture_output=True, text=True, check=True)
    pairs = (line.partition("=") for line in done.stdout.split("\0") if line)
    return {name: value for name, _, value in pairs if name in ("PATH", "PYTHONPATH") or "ROS" in name}
