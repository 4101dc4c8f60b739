"""A recorded tool in virtual time that writes its lines, too, to a line arbiter that can take it for dead."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any
from unittest.mock import patch

from end_effector_hal.control import Status, network_of
from end_effector_hal.runtime.outputs import Maintenance, OutputMapping, Outputs
from end_effector_hal.vocabulary import NO_PART, LastWill, LastWillStep, WrittenPart
from tests.support.recorded_tool import RecordedTool


class Arbiter:
    """Does what it is asked, and executes a last will."""

    def __init__(self) -> None:
        self.active: dict[str, bool] = {}
        self.will: LastWill = ()

    def recorded_part(self) -> str:
        return ""

    def declared_dead(self) -> bool:
        return False

    def levels(self) -> Mapping[str, bool]:
        return dict(self.active)

    def ask(
        self,
        levels: Mapping[str, bool],
        will: Sequence[LastWillStep],
        *,
        drop: bool = False,
        part: WrittenPart = NO_PART,
    ) -> Callable[[], int]:
        def wait() -> int:
            self.active |= levels
            self.will = tuple(will)
            return 0

        return wait

    def close(self, will: Sequence[LastWillStep]) -> None:
        self.will = tuple(will)


class RecordedLinesTool(RecordedTool):
    """The program with its lines."""

    outputs: Outputs | None = None

    def __init__(self, folder: Path, scenario: str = "nominal", **options: Any) -> None:
        self.at = 0
        self._clock = patch("end_effector_hal.runtime.boundary._recorded_lines.now_us", lambda: self.at)
        self._clock.start()
        self.arbiter = Arbiter()
        self._early: list[Status] = []
        super().__init__(folder, scenario, **options)
        self.lines = self.recorder.lines(self.arbiter)
        self._begin()

    def _begin(self) -> None:
        self.maintenance = Maintenance(self.description)
        self.outputs = Outputs(self.lines, OutputMapping(self.description, self.maintenance))
        early, self._early = self._early, []
        self._ask(early)

    def _told(self, statuses: list[Status]) -> None:
        super()._told(statuses)
        self._ask(statuses)

    def _ask(self, statuses: list[Status]) -> None:
        if self.outputs is None:
            self._early += statuses
        else:
            self.outputs.complete(self.outputs.begin(statuses))

    def die(self) -> None:
        """The arbiter takes the program for dead, and executes its last will; the program restarts."""
        for step in self.arbiter.will:
            self.arbiter.active[step.line] = step.level
            self._write({step.line: step.level}, self.at)
        self.controller = self.recorder.controller(self.description, network_of(self.description))
        self._begin()
        self._told(self.controller.start(self.lines.levels(), self.at))

    def drive(self, line: str, *, active: bool) -> None:
        """In maintenance."""
        assert self.outputs is not None
        will = self.outputs.mapping.maintenance_will(self.status, line, active=active)
        self.outputs.drive(line, active, will)
        self.maintenance.drove(line, active, self.at)
        self._write({line: active}, self.at)

    def close(self) -> None:
        if self.outputs is not None:
            self.lines.close(self.outputs.mapping.last_will(self.status, "sigterm"))
            self.outputs = None
        super().close()
        self._clock.stop()
