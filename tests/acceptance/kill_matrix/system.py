"""One running system: roscore, launch file with the line arbiter, testbench, client, and the observer."""

from __future__ import annotations

import os
import signal
import time
from contextlib import suppress
from pathlib import Path

from end_effector_hal.arbiter import ArbiterClient
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.errors import ReportedError, RosError
from end_effector_lab.demo._ros1 import Master
from end_effector_lab.demo._world import World
from end_effector_lab.processes import EEHAL, Child
from tests.acceptance.kill_matrix.hands import Hands
from tests.acceptance.kill_matrix.observer import Observer
from tests.acceptance.kill_matrix.waiting import Late, until

LAUNCHED = ("HALMain", "Grip", "ToolChange", "Pressure", "Position", "LineOwner")
START_S = 60.0
LATCHED = ("Over:", "GRIP_ERROR:", "RELEASE_ERROR:", "IL-03:")
"""Alarms that stay on purpose: of what is over, of the state that is expected, of what the line arbiter has ended."""


class Plant(World):
    """The hardware alone; the line arbiter comes with the launch file, which starts it again."""

    def _start(self) -> None:
        self.power_up()

    def power_up(self, scenario: str = "nominal") -> None:
        """Start the testbench; lines that are active have settled devices."""
        self.testbench = self.children.start(
            "testbench",
            [*EEHAL, "testbench", str(self.description_path), "--scenario", scenario],
            log=self.folder / f"testbench-{time.monotonic_ns()}.log",
            commands=True,
        )

    def wait_ready(self) -> None:
        """Until it answers."""
        self.testbench.wait_until(
            lambda: "ready:" in self.testbench.text(), timeout_s=START_S, what="it was ready"
        )


class System:
    """Starts on entering, ends on leaving with every process that it started (and no other)."""

    def __init__(self, folder: Path, description: Description | None = None) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self.folder = folder.absolute()
        self.plant = Plant(description or load(profile_path()), "nominal", self.folder)
        self.description = self.plant.description
        self._ros = Master(self.folder / "ros")

    def __enter__(self) -> System:
        try:
            self.plant.__enter__()
            self.plant.wait_ready()
            self.start_master()
            self._launch = self._start(
                "roslaunch", "roslaunch", "--wait", "end_effector_hal", "end_effector.launch",
                f"description:={self.plant.description_path}", end_by=signal.SIGINT, patience_s=15.0,
            )  # fmt: skip
            self.connect()
            self.observer = Observer(self.plant.chip)
            until("the whole system", self.is_up, START_S)
        except BaseException:
            self.plant.__exit__(None, None, None)
            raise
        return self

    def __exit__(self, *_: object) -> None:
        for name in LAUNCHED:
            self.send(name, signal.SIGCONT)
        with suppress(AttributeError):
            self.observer.close()
        self.plant.__exit__(None, None, None)

    def start_master(self) -> None:
        """A roscore on the port of this system."""
        log = self.folder / f"roscore-{time.monotonic_ns()}.log"
        self.master = self._ros.start(self.plant.children, log, patience_s=START_S)

    def connect(self) -> None:
        """A new client."""
        self.hands = Hands(
            self.plant.children,
            self.folder / f"client-{time.monotonic_ns()}.log",
            {**os.environ, **self._ros.env},
        )

    def supervisor(self, *arguments: str) -> Child:
        """A Supervisor; without a script it reads commands from `Child.tell`."""
        name = f"supervisor-{time.monotonic_ns()}"
        return self._start(name, "rosrun", "end_effector_hal", "supervisor", *arguments, commands=True)

    def pids(self, name: str) -> list[int]:
        """Of a process by its name in the matrix; processes of this system only."""
        if name == "testbench":
            return [self.plant.testbench.pid] if self.plant.testbench.code is None else []
        if name == "roscore":
            words: tuple[bytes, ...] = (b"roscore", b"rosmaster", b"__name:=rosout")
        else:
            words = (f"__name:={name}".encode(),)
        found = {pid: _command_line(pid) for pid in self.plant.children.left()}
        return [pid for pid, line in found.items() if any(any(w in part for w in words) for part in line)]

    def send(self, name: str, number: int) -> list[int]:
        """Send a signal to a process; returns whom it was sent to."""
        sent = []
        for pid in self.pids(name):
            with suppress(ProcessLookupError):
                os.kill(pid, number)
                sent.append(pid)
        return sent

    def clients_of_the_owner(self) -> set[str]:
        """Programs that hold a lease now; empty: there is no owner."""
        try:
            with ArbiterClient(self.plant.socket, "observer", patience_s=0.0, timeout_s=0.3) as owner:
                return {each["client"] for each in owner.status()["clients"] if not each["ended"]}
        except ReportedError:
            return set()

    def is_up(self) -> bool:
        """Every node was heard just now, the link is up, both programs hold their lease."""
        state, now = self.hands.look(), time.monotonic()
        fresh = all(now - self.hands.heard.get(name, 0) < 0.5 for name in LAUNCHED if name != "LineOwner")
        obstacles = [alarm for alarm in state.get("alarms", ()) if not alarm.startswith(LATCHED)]
        up = fresh and bool(state) and state["link_up"] and not obstacles
        return up and self.clients_of_the_owner() >= {"grip", "tool_change"}

    def why_not_up(self) -> str:
        """What `is_up` lacks, in words."""
        state, now = self.hands.look(), time.monotonic()
        silent = [
            name for name in LAUNCHED if name != "LineOwner" and now - self.hands.heard.get(name, 0) > 0.5
        ]
        return f"silent: {silent}, alarms: {state.get('alarms')}, leases: {self.clients_of_the_owner()}"

    def _start(self, name: str, *command: str, **options: object) -> Child:
        return self.plant.children.start(
            name, command, log=self.folder / f"{name}.log", failed=RosError, env=self._ros.env, **options
        )


def _command_line(pid: int) -> list[bytes]:
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
    except OSError:
        return []


__all__ = ["LAUNCHED", "Late", "Plant", "System"]
