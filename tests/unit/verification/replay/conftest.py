"""Runs in virtual time, recorded as real ones are."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from end_effector_hal.control import Answer, Controller
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.recording import Record, RecordingLimits, TraceWriter
from end_effector_hal.runtime.boundary import Recorder, open_recorder
from end_effector_hal.verification.replay import ProgramTrace, load_trace
from tests.support.patience import wait_until
from tests.support.virtual_tool import VirtualTool
from timed_automata import Network

Edit = Callable[[dict[str, Any]], object]
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


@pytest.fixture
def tool(tmp_path: Path) -> Iterator[Callable[..., RecordedTool]]:
    made: list[RecordedTool] = []

    def make(scenario: str = "nominal", **options: Any) -> RecordedTool:
        made.append(RecordedTool(tmp_path / "run", scenario, **options))
        return made[-1]

    yield make
    for each in made:
        each.close()


@pytest.fixture(scope="module")
def gripped(tmp_path_factory: pytest.TempPathFactory) -> ProgramTrace:
    """A grip in which the cylinder fails once, held and dropped."""
    tool = RecordedTool(tmp_path_factory.mktemp("gripped"), "fails-once:cylinder")
    tool.run(1.0)
    assert tool.command("grip").accepted
    tool.run(10.0)
    assert tool.command("drop").accepted
    tool.run(2.0)
    assert tool.status.ee == 6
    return tool.trace()


def edited(trace: ProgramTrace, number: int, edit: Edit | None) -> ProgramTrace:
    """With one record changed; ``None``: without it."""
    records = list(trace.file.records)
    if edit is None:
        del records[number]
    else:
        content = records[number].content
        edit(content)
        records[number] = Record(records[number].kind, json.dumps(content).encode())
    return replace(trace, file=replace(trace.file, records=tuple(records)))


def numbers(trace: ProgramTrace, kind: str, fits: Callable[[dict[str, Any]], object] = bool) -> list[int]:
    """The records of a kind that fit."""
    return [
        number
        for number, record in enumerate(trace.file.records)
        if record.kind == kind and fits(trace.content(number))
    ]
