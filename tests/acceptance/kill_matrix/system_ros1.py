"""The system in ROS 1: a master, and the launch file, which starts again what ends."""

from __future__ import annotations

import signal
import time
from pathlib import Path

from end_effector_hal.description import Description
from end_effector_hal.errors import RosError
from end_effector_lab.demo._ros import Master
from end_effector_lab.processes import Child
from tests.acceptance.kill_matrix.cells import NODES
from tests.acceptance.kill_matrix.system import START_S, System, lives
from tests.acceptance.kill_matrix.waiting import until


class Ros1System(System):
    """roscore, and the launch file with the line arbiter."""

    launched = (*NODES, "LineArbiter")

    def __init__(self, folder: Path, description: Description | None = None) -> None:
        super().__init__(folder, description)
        self._ros = Master(self.folder / "ros")

    def launch(self) -> None:
        self._start_master()
        self._start(
            "roslaunch", "roslaunch", "--wait", "end_effector_hal", "end_effector.launch",
            f"description:={self.plant.description_path}", end_by=signal.SIGINT, patience_s=15.0,
        )  # fmt: skip

    def connect(self) -> None:
        self.hands = self.hands_by("client_ros1", self._ros.env)

    def supervisor(self, script: str = "") -> Child:
        name = f"supervisor-{time.monotonic_ns()}"
        arguments = [f"_script:={script}"] if script else []
        return self._start(name, "rosrun", "end_effector_hal", "supervisor", *arguments, commands=True)

    def pids(self, name: str) -> list[int]:
        if name == "testbench":
            return [self.plant.testbench.pid] if self.plant.testbench.code is None else []
        if name == "roscore":
            words: tuple[bytes, ...] = (b"roscore", b"rosmaster", b"__name:=rosout")
        else:
            words = (f"__name:={name}".encode(),)
        found = {pid: _command_line(pid) for pid in self.plant.children.left()}
        return [pid for pid, line in found.items() if any(any(w in part for w in words) for part in line)]

    def leave_ended(self) -> None:
        """roslaunch starts them."""

    def ends_the_client(self, process: str) -> bool:
        return process == "roscore"

    def begin_anew(self, pids: list[int]) -> None:
        """The nodes notice that their master has gone, and leave; only then it is started again."""
        before = [pid for name in NODES for pid in self.pids(name)]
        until("the end of the master", lambda: not any(map(lives, pids)), 15.0)
        until("the nodes' leaving", lambda: not any(map(lives, before)), 20.0)
        self.plant.choose("nominal")
        self.hands.close()
        self._start_master()
        until("the nodes again", lambda: all(self.pids(name) for name in NODES), 20.0)
        self.connect()
        until("the client", self.hands.look, 30.0)

    def _start_master(self) -> None:
        log = self.folder / f"roscore-{time.monotonic_ns()}.log"
        self._ros.start(self.plant.children, log, patience_s=START_S)

    def _start(self, name: str, *command: str, **options: object) -> Child:
        return self.plant.children.start(
            name, command, log=self.folder / f"{name}.log", failed=RosError, env=self._ros.env, **options
        )


def _command_line(pid: int) -> list[bytes]:
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
    except OSError:
        return []
