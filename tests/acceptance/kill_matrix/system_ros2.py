"""The system in ROS 2: one process of the HAL or five."""

from __future__ import annotations

import time
from pathlib import Path

from end_effector_hal.description import Description
from end_effector_hal.errors import RosError
from end_effector_lab.demo._ros import PROGRAM, apart
from end_effector_lab.processes import Child
from tests.acceptance.kill_matrix.system_restarted import RestartedSystem

ONE = {"HAL": "hal"}
FIVE = {
    "Pressure": "pressure",
    "Position": "position",
    "Grip": "grip",
    "ToolChange": "tool_change",
    "HALMain": "hal_main",
}


class Ros2System(RestartedSystem):
    """The processes of the nodes, and the line arbiter.

    Args:
        programs: the name of a process in the matrix, to its executable.
    """

    failed = RosError

    def __init__(self, folder: Path, description: Description | None, programs: dict[str, str]) -> None:
        super().__init__(folder, description, *programs)
        self._executables = programs
        self.env = apart(self.folder / "ros")

    def connect(self) -> None:
        self.hands = self.hands_by("client_ros2", self.env)

    def supervisor(self, script: str = "") -> Child:
        arguments = ["--ros-args", "-p", f"script:={script}"] if script else []
        name = f"supervisor-{time.monotonic_ns()}"
        return self.child(name, [*PROGRAM, "supervisor", *arguments], commands=True)

    def command_of(self, name: str) -> list[str]:
        path = str(self.plant.description_path)
        return [*PROGRAM, self._executables[name], "--ros-args", "-p", f"description:={path}"]
