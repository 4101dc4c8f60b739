"""A tool in virtual time that records its run as a real one does."""

from __future__ import annotations

from pathlib import Path

from end_effector_hal.control import Answer
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.recording import RecordingLimits, TraceWriter
from end_effector_hal.runtime.boundary import open_recorder
from end_effector_hal.verification.replay import ProgramTrace, load_trace
from tests.support.patience import wait_until
from tests.support.virtual_tool import VirtualTool

PIECE_S = 0.5


def drained(writer: TraceWriter) -> None:
    """What was handed over is written, or is lost."""
    wait_until("the writer", lambda: not writer._queued and not writer._ordered)


class RecordedTool(VirtualTool):
    """A program in virtual time, with its trace in ``folder``."""

    def __init__(
        self,
        folder: Path,
        scenario: str = "nominal",
        levels: dict[str, bool] | None = None,
        limits: RecordingLimits | None = None,
        description: Description | None = None,
    ) -> None:
        self.folder, description = folder, description or load(profile_path())
        self.recorder = open_recorder(folder, description, at=0, limits=limits)
        super().__init__(description, scenario, levels=levels, controller=self.recorder.controller)

    def run(self, seconds: float) -> None:
        until = self.at + round(seconds * 1e6)
        while self.at < until:
            super().run(min(PIECE_S, (until - self.at) / 1e6))
            self.flush()

    def command(self, name: str, part: str = "") -> Answer:
        answer = super().command(name, part)
        self.flush()
        return answer

    def flush(self) -> None:
        """As a program does after each job; virtual time waits until all of it is written."""
        self.recorder.flush()
        assert self.recorder._writer is not None
        drained(self.recorder._writer)

    def close(self) -> None:
        self.recorder.close()

    def trace(self) -> ProgramTrace:
        """What was recorded; the run is over."""
        self.close()
        return load_trace(self.folder / "hal.mcap")


def recorded(folder: Path, scenario: str, *plan: str | float, description: Description | None = None) -> Path:
    """The recording of a tool that got these commands, such as ``grip box``, with seconds between them."""
    tool = RecordedTool(folder, scenario, description=description)
    for step in plan:
        if isinstance(step, str):
            tool.command(*step.split())
        else:
            tool.run(step)
    tool.close()
    return folder
