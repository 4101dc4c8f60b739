"""Recordings of days on which a real tool in virtual time gripped."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime, timedelta
from pathlib import Path

from end_effector_hal.control import Status
from end_effector_hal.description import Description
from end_effector_hal.recording import Recording
from end_effector_hal.signals import Frame
from end_effector_lab.testbench import Sent
from tests.support.virtual_tool import VirtualTool

MONDAY = datetime.fromisoformat("2026-03-02T12:00:00+00:00")


class WithTables(VirtualTool):
    """A tool in virtual time that writes the tables of a recording."""

    def __init__(self, folder: Path, tool: Description, scenario: str, started: datetime) -> None:
        self.recording = Recording(folder, tool, scenario=scenario, started=started, now=lambda: 0)
        super().__init__(tool, scenario)

    def _heard(self, sent: Sent, frames: list[Frame]) -> None:
        for frame in frames:
            self.recording.values(frame.at, frame.values)

    def _told(self, statuses: list[Status]) -> None:
        super()._told(statuses)
        for status in statuses:
            self.recording.state(status.at, status.ee, status.command, status.actuators)
            self.recording.part(status.at, status.part)
            self.recording.events(status.at, status.events)


def run_of(folder: Path, tool: Description, scenario: str, day: int, parts: Sequence[str] = ("",)) -> Path:
    """The recording of a day on which these parts were gripped, each held for a second and dropped."""
    recorded = WithTables(folder, tool, scenario, MONDAY + timedelta(days=day))
    recorded.run(1.5)
    for part in parts:
        assert recorded.command("grip", part).accepted
        recorded.play(3.0, "drop", 2.0)
    recorded.recording.close()
    return folder
