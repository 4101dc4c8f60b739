"""Plays the cells of a grid on all workers, or one of them as a recording; results are stored at once, so that a
stopped grid can continue.
"""

from __future__ import annotations

import os
import tempfile
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path

from pydantic import ConfigDict, TypeAdapter

from end_effector_hal.cli import the_folder
from end_effector_hal.control import Status
from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError, os_errors
from end_effector_hal.recording import Moment, Recording, read_run
from end_effector_hal.signals import Frame
from end_effector_lab.results import ResultsFolder, ResultsLayout, mark_of
from end_effector_lab.workers import ShippedAutomata, Workers

from ._case import KILL, NOMINAL, SCENARIO, START, Outcome
from ._grid import Cell
from ._play import Trial, no_log, play_case

FMEA, PAGE, FIGURES = "fmea.csv", "report.html", "report.json"
LAYOUT = ResultsLayout(
    "matrix",
    "matrix.json",
    "cells.jsonl",
    "Remove the line: its cell is played again.",
    (PAGE, FIGURES, FMEA),
)


@dataclass(frozen=True)
class Played:
    """A cell with its result.

    Attributes:
        id: the cell.
        seconds: time from the fault to the last change of a line.
        told, told_after: the first alarm or reason after the fault, and its delay in s.
        lines: every later change of a line: seconds, line, level.
        objections: sentences of the monitor and of the judge.
        dropped: whether an output of a held part became inactive without a drop.
        let_go: the same, because its device receives nothing, as its description declares (`on_link_loss`).
    """

    __pydantic_config__ = ConfigDict(extra="forbid", allow_inf_nan=False)

    id: str
    outcome: Outcome
    seconds: float
    told: str = ""
    told_after: float | None = None
    lines: tuple[tuple[float, str, bool], ...] = ()
    objections: tuple[str, ...] = ()
    dropped: bool = False
    let_go: bool = False


_SHAPE = TypeAdapter(Played)


def play(description: Description, cell: Cell) -> Played:
    """Play a cell and judge it."""
    return result_of(cell, play_case(description, cell.case))


def result_of(cell: Cell, trial: Trial) -> Played:
    """Return what happened from the fault until all faults were removed."""
    begun, tool = trial.marks[len(cell.moment.before)], trial.tool
    at = trial.origin + cell.moment.at
    lines = tuple(
        (round((edge.at - at) / 1e6, 6), edge.line, edge.level)
        for edge in tool.edges[begun.edges : trial.ended.edges]
    )
    told, told_after = _told(tool.statuses[: trial.ended.statuses], begun.statuses, at)
    if not told and trial.refused_since(at):
        told, told_after = "The command was refused.", 0.0
    failures = trial.failures
    return Played(
        cell.id, trial.outcome, round(lines[-1][0] if lines else 0.0, 3), told, told_after, lines,
        tuple(failures.values()), "held" in failures, trial.let_go,
    )  # fmt: skip


def _told(statuses: Sequence[Status], first: int, at: int) -> tuple[str, float | None]:
    """Return the first new alarm or reason, and its delay; "" if there is none."""
    known = {text for status in statuses[first - 1 : first] for text in _texts(status)}
    for status in statuses[first:]:
        for text in _texts(status):
            if text and text not in known:
                return text, round((status.at - at) / 1e6, 3)
    return "", None


def _texts(status: Status) -> tuple[str, ...]:
    return (*status.alarm_texts, status.reason, status.changer_reason)


def matrix_folder(description: Description, folder: Path) -> ResultsFolder:
    """Return the results folder of a grid; raises UsageError if it cannot be used or belongs to other results."""
    return ResultsFolder(folder, LAYOUT, mark_of(description))


def play_all(
    description: Description,
    cells: Sequence[Cell],
    results: ResultsFolder,
    *,
    workers: Workers,
    on_progress: Callable[[int, int], None] = lambda _, __: None,
) -> dict[str, Played]:
    """Play the cells that were not played yet; return all results by id, in the order of the grid.

    Args:
        cells: cells of the grid.
        results: the earlier results for this tool.
        workers: play the cells.
        on_progress: called with the number of played cells and the total.

    Raises:
        UsageError: a stored line does not fit, or a result cannot be stored.
        WorkersError: the workers cannot be reached or do not fit, or some cells were not played.
    """
    done = results.by_key(_SHAPE, lambda each, _: each.id, "cell")
    todo = [cell for cell in cells if cell.id not in done]
    on_progress(len(cells) - len(todo), len(cells))
    shared = description, ShippedAutomata.read(description)
    for number, (cell, played) in enumerate(workers.each(_play, shared, todo), start=1):
        done[cell.id] = played
        results.append(asdict(played))
        on_progress(len(cells) - len(todo) + number, len(cells))
    return {cell.id: done[cell.id] for cell in cells if cell.id in done}


def _play(shared: tuple[Description, ShippedAutomata], cell: Cell) -> Played:
    description, automata = shared
    with no_log():
        return play(automata.of(description), cell)


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
