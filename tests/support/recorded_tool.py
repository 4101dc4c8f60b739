"""A tool in virtual time that records its run as a real one does."""

from __future__ import annotations

from pathlib import Path

from end_effector_hal.control import Answer, Controller
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.recording import RecordingLimits, TraceWriter
from end_effector_hal.runtime.boundary import Recorder, open_recorder
from end_effector_hal.verification.replay import ProgramTrace, load_trace
from tests.support.patience import wait_until
from tests.support.virtual_tool import VirtualTool
from timed_automata import Network

PIECE_S = 0.5


def drained(writer: TraceWriter) -> None:
    """What was handed over is written, or is lost."""
    wait_until("the writer", lambda: not writer._queued and not writer._ordered)


class RecordedTool(VirtualTool):
    """Both programs in virtual time, each with its trace in ``folder``."""

    def __init__(
        self,
        folder: Path,
        scenario: str = "nominal",
        levels: dict[str, bool] | None = None,
        limits: RecordingLimits | None = None,
        description: Description | None = None,
    ) -> None:
        self.recorders: list[Recorder] = []
        self.folder = folder

        def recorded(description: Description, network: Network, program: str) -> Controller:
            self.recorders.append(open_recorder(folder, description, program, at=0, limits=limits))
            return self.recorders[-1].controller(description, network, program)

        super().__init__(description or load(profile_path()), scenario, levels=levels, controller=recorded)

    def run(self, seconds: float) -> None:
        until = self.at + round(seconds * 1e6)
        while self.at < until:
            super().run(min(PIECE_S, (until - self.at) / 1e6))
            self.flush()

    def command(self, name: str) -> Answer:
        answer = super().command(name)
        self.flush()
        return answer

    def flush(self) -> None:
        """As a unit does after each job; virtual time waits until all of it is written."""
        for recorder in self.recorders:
            recorder.flush()
            assert recorder._writer is not None
            drained(recorder._writer)

    def close(self) -> None:
        for recorder in self.recorders:
            recorder.close()

    def trace(self, program: str = "grip") -> ProgramTrace:
        """What was recorded; the run is over."""
        self.close()
        return load_trace(self.folder / f"{program}.mcap")


def recorded(folder: Path, scenario: str, *plan: str | float) -> Path:
    """The recording of a tool that got these commands, with seconds between them."""
    tool = RecordedTool(folder, scenario)
    for step in plan:
        if isinstance(step, str):
            tool.command(step)
        else:
            tool.run(step)
    tool.close()
    return folder
