"""Plays the cells of a grid on all workers, or one of them as a recording."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from end_effector_hal.control import Status
from end_effector_hal.description import Description
from end_effector_hal.recording import Moment, Recording
from end_effector_hal.signals import Frame
from end_effector_lab.results import append_line
from end_effector_lab.workers import ShippedAutomata, Workers

from ._case import KILL, NOMINAL, SCENARIO, START, Outcome
from ._grid import Cell
from ._play import Trial, no_log, play_case

FMEA, PAGE, FIGURES, CELLS = "fmea.csv", "report.html", "report.json", "cells.jsonl"


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

    id: str
    outcome: Outcome
    seconds: float
    told: str = ""
    told_after: float | None = None
    lines: tuple[tuple[float, str, bool], ...] = ()
    objections: tuple[str, ...] = ()
    dropped: bool = False
    let_go: bool = False


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


def play_all(
    description: Description,
    cells: Sequence[Cell],
    *,
    workers: Workers,
    lines: Path | None = None,
    on_progress: Callable[[int, int], None] = lambda _, __: None,
) -> dict[str, Played]:
    """Play cells, and return the results by id, in the order of the grid.

    Args:
        cells: cells of the grid.
        workers: play the cells.
        lines: file to which each result is appended, JSON lines.
        on_progress: called with the number of played cells and the total.

    Raises:
        UsageError: a result cannot be stored.
        WorkersError: the workers cannot be reached or do not fit, or some cells were not played.
    """
    done: dict[str, Played] = {}
    on_progress(0, len(cells))
    shared = description, ShippedAutomata.read(description)
    for number, (cell, played) in enumerate(workers.each(_play, shared, cells), start=1):
        done[cell.id] = played
        if lines is not None:
            append_line(lines, asdict(played))
        on_progress(number, len(cells))
    return {cell.id: done[cell.id] for cell in cells}


def _play(shared: tuple[Description, ShippedAutomata], cell: Cell) -> Played:
    description, automata = shared
    with no_log():
        return play(automata.of(description), cell)


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
