"""A system whose processes are started again when they end, as a service manager does."""

from __future__ import annotations

import signal
import threading
import time
from abc import abstractmethod
from collections.abc import Mapping
from pathlib import Path

from end_effector_hal.description import Description
from end_effector_hal.errors import ReportedError
from end_effector_lab.processes import EEHAL, Child
from tests.acceptance.kill_matrix.system import System

AGAIN_S = 1.0
"""After its end a process is started again, as by `RestartSec` of the units."""
LINE_ARBITER = "LineArbiter"


class RestartedSystem(System):
    """The line arbiter, and other processes.

    Attributes:
        env: what is added to the environment of each.
        failed: what is raised when one cannot be started.
    """

    env: Mapping[str, str] = {}
    failed: type[ReportedError] = ReportedError

    def __init__(self, folder: Path, description: Description | None, *others: str) -> None:
        super().__init__(folder, description)
        self.launched = (LINE_ARBITER, *others)
        self._running: dict[str, Child] = {}
        self._ended = threading.Event()
        self._keeper = threading.Thread(target=self._keep, name="keeper", daemon=True)

    @abstractmethod
    def command_of(self, name: str) -> list[str]:
        """Program and arguments of another process than the line arbiter."""

    def launch(self) -> None:
        for name in self.launched:
            self._start(name)
        self._keeper.start()

    def pids(self, name: str) -> list[int]:
        child = self.plant.testbench if name == "testbench" else self._running.get(name)
        return [child.pid] if child is not None and child.code is None else []

    def leave_ended(self) -> None:
        self._ended.set()
        if self._keeper.is_alive():
            self._keeper.join()

    def child(self, name: str, command: list[str], **options: object) -> Child:
        """Start a process with a log of its own."""
        return self.plant.children.start(
            name, command, log=self.folder / f"{name}.log", failed=self.failed, env=self.env, **options
        )

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
        arbiter = name == LINE_ARBITER
        command = [*EEHAL, "arbiter", str(self.plant.description_path)] if arbiter else self.command_of(name)
        self._running[name] = self.child(
            f"{name}-{time.monotonic_ns()}",
            command,
            end_by=signal.SIGINT,
            patience_s=15.0,
            outlives_us=arbiter,
        )
