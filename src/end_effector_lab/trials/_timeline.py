"""Writes one cell as a recording, which other commands of `eehal` can read, with its figure."""

from __future__ import annotations

import os
import tempfile
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from end_effector_hal.cli import the_folder
from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError, os_errors
from end_effector_hal.recording import Moment, Recording, read_run
from end_effector_hal.signals import Frame

from ._case import KILL, NOMINAL, SCENARIO, START
from ._grid import Cell
from ._play import no_log, play_case
from ._run_grid import Played, result_of

TIMELINE = "timeline.png"
_WRITTEN = (
    "run.json",
    "states.csv",
    "events.csv",
    "pressures.csv",
    "switches.csv",
    "tool_changer.csv",
    "parts.csv",
    "alarms.csv",
    TIMELINE,
)


@contextmanager
def cell_folder(folder: Path) -> Iterator[Path]:
    """Yield an empty folder for a cell; its files replace those of the cell in ``folder``, unless an error is raised.

    Raises:
        UsageError: ``folder`` is no folder, or holds a file of another program; then nothing of it is changed.
    """
    _check_folder(folder)
    with tempfile.TemporaryDirectory(prefix=f".{folder.name}.", dir=the_folder(folder.parent)) as name:
        new = Path(name)
        yield new
        _check_folder(the_folder(folder))
        with os_errors("The folder cannot be replaced", folder):
            for written in _WRITTEN:  # run.json first: it shows that the folder is ours
                if (new / written).exists():
                    (new / written).replace(folder / written)
                else:
                    (folder / written).unlink(missing_ok=True)


def _check_folder(folder: Path) -> None:
    todo = "Move it away, or name another folder with -o."
    if not os.path.lexists(folder):
        return
    if folder.is_symlink() or not folder.is_dir():
        raise UsageError("This is not a folder.", where=str(folder), todo=todo)
    with os_errors("The folder cannot be read", folder):
        found = sorted(os.scandir(folder), key=lambda each: each.name)
    other = [
        each.name for each in found if each.name not in _WRITTEN or not each.is_file(follow_symlinks=False)
    ]
    if other:
        raise UsageError(
            f"The folder contains {other[0]!r}, which no cell of a matrix wrote.",
            where=str(folder),
            todo=todo,
        )
    if found and " @ " not in read_run(folder).scenario:  # no scenario of a testbench contains it
        raise UsageError(
            "The folder contains a recording that no cell of a matrix wrote.", where=str(folder), todo=todo
        )


def disturbances(cell: Cell) -> tuple[Moment, ...]:
    """Return the disturbances of the tool for its figure; commands are already part of its story."""
    at, found = cell.moment.at, dict[int, list[str]]()
    for each in cell.case.happenings:
        if each.verb == SCENARIO and each.rest != NOMINAL:
            found.setdefault(each.at, []).append(each.rest)
        elif each.verb == KILL:
            found.setdefault(each.at, []).append(cell.command)
        elif each.verb == START:
            found.setdefault(each.at, []).append("started again" if each.at > at else "started again at once")
    return tuple(Moment(at / 1e6, "disturbed", ", ".join(texts)) for at, texts in found.items())


def record(description: Description, cell: Cell, folder: Path) -> Played:
    """Play a cell and write its recording into a folder, in time after the tool has come to rest.

    Raises:
        UsageError: it cannot be written.
    """
    frames: list[Frame] = []
    with no_log():
        trial = play_case(description, cell.case, on_frame=frames.append)
    lines = description.lines.model_copy(update={"backend": "virtual"})  # whatever the wires of the tool are
    played_on = description.model_copy(update={"lines": lines})
    with Recording(folder, played_on, scenario=cell.id, seed=0, now=lambda: 0) as recording:
        waiting = deque(each for each in frames if trial.origin <= each.at <= trial.ended.at)

        def write_frames(until: int) -> None:
            while waiting and waiting[0].at <= until:
                frame = waiting.popleft()
                recording.values(frame.at - trial.origin, frame.values)

        for status in trial.tool.statuses[trial.marks[0].statuses - 1 : trial.ended.statuses]:
            at = max(0, status.at - trial.origin)
            write_frames(status.at)
            recording.tool_changer(at, status.changer)
            recording.state(at, status.ee, status.command, status.actuators)
            recording.part(at, status.part)
            recording.alarms(at, status.alarms)
            recording.events(at, status.events)
        write_frames(trial.ended.at)
    return result_of(cell, trial)
