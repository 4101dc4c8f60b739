"""The system in ROS 2: one process of the HAL or five, each started again when it ends, as a service manager does."""

from __future__ import annotations

import signal
import threading
import time
from pathlib import Path

from end_effector_hal.description import Description
from end_effector_hal.errors import RosError
from end_effector_lab.demo._ros2 import PROGRAM, apart
from end_effector_lab.processes import EEHAL, Child
from tests.acceptance.kill_matrix.system import System

AGAIN_S = 1.0
"""After its end a process is started again, as by `RestartSec` of the units."""
LINE_OWNER = "LineOwner"
ONE = {"HAL": "hal"}
FIVE = {
    "Pressure": "pressure",
    "Position": "position",
    "Grip": "grip",
    "ToolChange": "tool_change",
    "HALMain": "hal_main",
}


class Ros2System(System):
    """The processes of the nodes, and the line arbiter.

    Args:
        programs: the name of a process in the matrix, to its executable.
    """

    def __init__(self, folder: Path, description: Description | None, programs: dict[str, str]) -> None:
        super().__init__(folder, description)
        self.launched = (LINE_OWNER, *programs)
        self._programs = programs
        self._env = apart(self.folder / "ros")
        self._running: dict[str, Child] = {}
        self._ended = threading.Event()
        self._keeper = threading.Thread(target=self._keep, name="keeper", daemon=True)

    def launch(self) -> None:
        for name in self.launched:
            self._start(name)
        self._keeper.start()

    def connect(self) -> None:
        self.hands = self.hands_by("client_ros2", self._env)

    def supervisor(self, script: str = "") -> Child:
        arguments = ["--ros-args", "-p", f"script:={script}"] if script else []
        name = f"supervisor-{time.monotonic_ns()}"
        return self._child(name, [*PROGRAM, "supervisor", *arguments], commands=True)

    def pids(self, name: str) -> list[int]:
        child = self.plant.testbench if name == "testbench" else self._running.get(name)
        return [child.pid] if child is not None and child.code is None else []

    def leave_ended(self) -> None:
        self._ended.set()
        if self._keeper.is_alive():
            self._keeper.join()

    def _keep(self) -> None:
        since: dict[str, float] = {}
        while not self._ended.wait(0.05):
            now = time.monotonic()
            for name, child in list(self._running.items()):
                if child.code is None:
                    since.pop(name, None)
                elif now - since.setdefault(name, now) >= AGAIN_S:
                    self._start(name)

    def _start(self, name: str) -> None:
        path = str(self.plant.description_path)
        command = (
            [*EEHAL, "arbiter", path]
            if name == LINE_OWNER
            else [*PROGRAM, self._programs[name], "--ros-args", "-p", f"description:={path}"]
        )
        self._running[name] = self._child(
            f"{name}-{time.monotonic_ns()}", command, end_by=signal.SIGINT, patience_s=15.0,
            outlives_us=name == LINE_OWNER,
        )  # fmt: skip

    def _child(self, name: str, command: list[str], **options: object) -> Child:
        return self.plant.children.start(
            name, command, log=self.folder / f"{name}.log", failed=RosError, env=self._env, **options
        )
