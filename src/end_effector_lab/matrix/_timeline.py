"""One cell as a recording, which every command of `eehal` that takes one reads, and its figure."""

from __future__ import annotations

from pathlib import Path

from end_effector_hal.description import Description
from end_effector_hal.recording import Recording
from end_effector_hal.signals import Frame

from ._cells import Cell
from ._play import CellRun, Played
from ._run import no_log


def record(description: Description, cell: Cell, folder: Path) -> Played:
    """Play a cell and write its recording into a folder; raises UsageError if that cannot be written."""
    frames: list[Frame] = []
    with no_log():
        run = CellRun(description, cell, frames.append)
        played, tool = run.played(), run.tool
    with Recording(folder, description, scenario=cell.id, now=lambda: 0) as recording:
        told = [(status.at, 0, status) for status in tool.statuses]
        told += [(status.at, 1, status) for status in tool.changes]
        waiting = iter(frames)
        frame = next(waiting, None)
        for at, changer, status in sorted(told, key=lambda each: each[:2]):
            while frame is not None and frame.at <= at:
                recording.values(frame.at, frame.values)
                frame = next(waiting, None)
            if changer:
                recording.tool_changer(at, status.changer)
            else:
                recording.state(at, status.ee, status.command, status.actuators)
                recording.alarms(at, status.alarms)
        while frame is not None:
            recording.values(frame.at, frame.values)
            frame = next(waiting, None)
    return played
