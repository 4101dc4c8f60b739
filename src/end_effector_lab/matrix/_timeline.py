"""One cell as a recording, which every command of `eehal` that takes one reads, and its figure."""

from __future__ import annotations

from contextlib import AbstractContextManager
from pathlib import Path

from end_effector_hal.description import Description
from end_effector_hal.recording import Moment, Recording, read_run
from end_effector_hal.signals import Frame
from end_effector_lab.results import replaced_folder

from ._cells import NO_FAULT, Cell
from ._play import DEAD_US, CellRun, Played, Undisturbed
from ._run import no_log

TIMELINE = "timeline.png"
_WRITTEN = (
    "run.json",
    "states.csv",
    "events.csv",
    "pressures.csv",
    "switches.csv",
    "tool_changer.csv",
    "alarms.csv",
    TIMELINE,
)


def cell_folder(folder: Path) -> AbstractContextManager[Path]:
    """A new folder for a cell, which replaces that of another cell; raises UsageError if it holds anything else."""
    return replaced_folder(folder, _WRITTEN, _is_a_cell, "cell of a matrix")


def _is_a_cell(folder: Path) -> bool:
    return " @ " in read_run(folder).scenario  # no scenario that a testbench takes has it


def disturbances(cell: Cell) -> tuple[Moment, ...]:
    """What happens to the tool, for its figure; commands are a part of its story."""
    killed = cell.command if cell.command.startswith("kill") else ""
    what = ", ".join(filter(None, ("" if cell.name == NO_FAULT else cell.fault, killed)))
    at, again = cell.moment.at, "started again"
    if killed and cell.at_once:
        found = [(at, f"{what}, {again} at once")]
    else:
        found = [*([(at, what)] if what else []), *([(at + DEAD_US, again)] if killed else [])]
    return tuple(Moment(at / 1e6, "disturbed", text) for at, text in found)


def record(description: Description, cell: Cell, folder: Path) -> Played:
    """Play a cell and write its recording into a folder; raises UsageError if that cannot be written."""
    frames: list[Frame] = []
    with no_log():
        run = CellRun(Undisturbed(description, frames.append), cell)
        played, tool = run.played(), run.tool
    lines = description.lines.model_copy(update={"backend": "virtual"})  # whatever the wires of the tool are
    played_on = description.model_copy(update={"lines": lines})
    with Recording(folder, played_on, scenario=cell.id, seed=0, now=lambda: 0) as recording:
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
            recording.events(at, status.events)
        while frame is not None:
            recording.values(frame.at, frame.values)
            frame = next(waiting, None)
    return played
