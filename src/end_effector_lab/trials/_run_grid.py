"""Plays the cells of a grid on all workers; results are stored at once, so that a stopped grid can continue."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from pydantic import ConfigDict, TypeAdapter

from end_effector_hal.control import Status
from end_effector_hal.description import Description
from end_effector_lab.results import ResultsFolder, ResultsLayout, mark_of
from end_effector_lab.workers import ShippedAutomata, Workers

from ._grid import Cell
from ._outcome import Outcome
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
    done = _kept(results)
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


def _kept(results: ResultsFolder) -> dict[str, Played]:
    """Return the stored results by the id of their cell."""
    done: dict[str, Played] = {}
    for where, played in results.lines(_SHAPE):
        if played.id in done:
            raise results.misfit("its cell is in an earlier line, too.", where)
        done[played.id] = played
    return done
