"""One running system: the nodes, the line arbiter, the testbench, a client, and the observer."""

from __future__ import annotations

import os
import signal
import time
from abc import ABC, abstractmethod
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from end_effector_hal.arbiter import HAL, ArbiterClient
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.errors import ReportedError
from end_effector_lab.demo._world import World
from end_effector_lab.processes import EEHAL, Child
from tests.acceptance.kill_matrix.client import HEARD
from tests.acceptance.kill_matrix.hands import Hands
from tests.acceptance.kill_matrix.observer import Observer
from tests.acceptance.kill_matrix.waiting import until

START_S = 60.0
LATCHED = ("Over:", "GRIP_ERROR:", "RELEASE_ERROR:", "IL-03:", "The tool changer is in FAULT")
"""Alarms that stay on purpose: of what is over, of the state that is expected, of what the line arbiter has ended."""


class Plant(World):
    """The hardware alone; the line arbiter comes with the nodes, and is started again as they are."""

    def _start(self) -> None:
        self.power_up()

    def power_up(self, scenario: str = "nominal") -> None:
        """Start the testbench; lines that are active have settled devices."""
        models = ["--model", self._models] if self._models else []
        self.testbench = self.children.start(
            "testbench",
            [*EEHAL, "testbench", str(self.description_path), "--scenario", scenario, *models],
            log=self.folder / f"testbench-{time.monotonic_ns()}.log",
            commands=True,
        )

    def wait_ready(self) -> None:
        """Until it answers."""
        self.testbench.wait_until(
            lambda: "ready:" in self.testbench.text(), timeout_s=START_S, what="it was ready"
        )


class System(ABC):
    """Starts on entering, ends on leaving with every process that it started (and no other).

    Attributes:
        launched: names of the processes that are started again when they end.
        nodes: whom a client must hear.
    """

    launched: Sequence[str] = ()
    nodes: Sequence[str] = ("HALMain", *HEARD.values())

    def __init__(self, folder: Path, description: Description | None = None) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self.folder = folder.absolute()
        self.plant = Plant(description or load(profile_path()), "nominal", self.folder)
        self.description = self.plant.description

    @abstractmethod
    def launch(self) -> None:
        """Start the nodes and the line arbiter."""

    @abstractmethod
    def connect(self) -> None:
        """A new client."""

    @abstractmethod
    def supervisor(self, script: str = "") -> Child:
        """A Supervisor; without a script it reads commands from `Child.tell`."""

    @abstractmethod
    def pids(self, name: str) -> list[int]:
        """Of a process by its name in the matrix; processes of this system only."""

    def ends_the_client(self, process: str) -> bool:
        """Whether the client ends with this process: what nodes live of (a master), or the client itself."""
        return False

    def begin_anew(self, pids: list[int]) -> None:
        """A process that ends the client has ended: have everything back, and a new client."""
        raise AssertionError("there is no such process")

    @abstractmethod
    def leave_ended(self) -> None:
        """Nothing is started again by this process from now on."""

    def __enter__(self) -> System:
        try:
            self.plant.__enter__()
            self.plant.wait_ready()
            self.observer = Observer(self.plant.chip, self.description.opposites)
            self.launch()
            self.connect()
            until("the whole system", self.is_up, START_S)
        except BaseException:
            self.leave_ended()
            self.plant.__exit__(None, None, None)
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.leave_ended()
        for name in self.launched:
            self.send(name, signal.SIGCONT)
        with suppress(AttributeError):
            self.observer.close()
            self.hands.close()
        self.plant.__exit__(None, None, None)

    def hands_by(self, client: str, env: dict[str, str]) -> Hands:
        """A client of this system."""
        log = self.folder / f"client-{time.monotonic_ns()}.log"
        return Hands(self.plant.children, client, log, {**os.environ, **env})

    def send(self, name: str, number: int) -> list[int]:
        """Send a signal to a process; returns whom it was sent to."""
        sent = []
        for pid in self.pids(name):
            with suppress(ProcessLookupError):
                os.kill(pid, number)
                sent.append(pid)
        return sent

    def clients_of_the_arbiter(self) -> set[str]:
        """Programs that hold a lease now; empty: there is no arbiter."""
        try:
            with ArbiterClient(self.plant.socket, "observer", patience_s=0.0, timeout_s=0.3) as arbiter:
                return {each["client"] for each in arbiter.status()["clients"] if not each["ended"]}
        except ReportedError:
            return set()

    def is_up(self) -> bool:
        """Every node was heard just now, the link is up, the program holds its lease."""
        state = self.hands.look()
        obstacles = [alarm for alarm in state.get("alarms", ()) if not alarm.startswith(LATCHED)]
        up = not self._silent() and bool(state) and state["link_up"] and not obstacles
        return up and HAL in self.clients_of_the_arbiter()

    def why_not_up(self) -> str:
        """What `is_up` lacks, in words."""
        alarms = self.hands.look().get("alarms")
        return f"silent: {self._silent()}, alarms: {alarms}, leases: {self.clients_of_the_arbiter()}"

    def _silent(self) -> list[str]:
        now = time.monotonic()
        return [name for name in self.nodes if now - self.hands.heard.get(name, 0) > 0.5]


def lives(pid: int) -> bool:
    """Whether a process runs, or is stopped."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except OSError:
        return False
