"""The system without ROS: the whole HAL in one process, which is the client as well."""

from __future__ import annotations

from pathlib import Path

from end_effector_hal.description import Description
from end_effector_lab.processes import Child
from tests.acceptance.kill_matrix.cells import BOTH, gripping
from tests.acceptance.kill_matrix.system import lives
from tests.acceptance.kill_matrix.system_restarted import LINE_ARBITER, RestartedSystem
from tests.acceptance.kill_matrix.waiting import until


class PlainSystem(RestartedSystem):
    """`EndEffector` in one process, and the line arbiter."""

    nodes = ("HAL",)

    def __init__(self, folder: Path, description: Description | None, part: str = "") -> None:
        super().__init__(folder, description)
        self._part = part
        self.description = gripping(self.description, part)

    def connect(self) -> None:
        told = {"EEHAL_KILLED": str(self.plant.description_path), "EEHAL_KILLED_PART": self._part}
        self.hands = self.hands_by("client_plain", told)

    def supervisor(self, script: str = "") -> Child:
        raise AssertionError("there is no such process")

    def command_of(self, name: str) -> list[str]:
        raise AssertionError("there is no such process")

    def pids(self, name: str) -> list[int]:
        own = [self.hands.process.pid] if self.hands.process.code is None else []
        if name == BOTH:
            return [*own, *super().pids(LINE_ARBITER)]
        return own if name == "HAL" else super().pids(name)

    def ends_the_client(self, process: str) -> bool:
        return process in ("HAL", BOTH)

    def begin_anew(self, pids: list[int]) -> None:
        until("their end", lambda: not any(map(lives, pids)), 10.0)
        self.hands.close()
        self.plant.choose("nominal")
        self.connect()
        until("the HAL again", self.hands.look)
