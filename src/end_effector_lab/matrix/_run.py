"""Plays all cells of a matrix on all workers; results are stored at once, so that a stopped matrix can continue."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, TypeVar

from pydantic import TypeAdapter

from end_effector_hal.description import Description
from end_effector_lab.results import ResultsFolder, ResultsLayout, mark_of
from end_effector_lab.workers import ShippedAutomata, Workers

from ._cells import WORDS, Cell, Outcome
from ._play import CellRun, Played, Undisturbed
from ._script import PHASES

FMEA, PAGE, FIGURES = "fmea.csv", "report.html", "report.json"
LAYOUT = ResultsLayout(
    "matrix",
    "matrix.json",
    "cells.jsonl",
    "Remove the line: its cell is played again.",
    (PAGE, FIGURES, FMEA),
)
T = TypeVar("T")
_SHAPE = TypeAdapter(Played)
_OUTCOMES = frozenset(each.value for each in Outcome)


def matrix_folder(description: Description, folder: Path) -> ResultsFolder:
    """Return the results folder of a matrix; raises UsageError if it cannot be used or belongs to other results."""
    return ResultsFolder(folder, LAYOUT, mark_of(description))


def play_all(
    description: Description,
    cells: Sequence[Cell],
    results: ResultsFolder,
    *,
    workers: Workers,
    on_progress: Callable[[int, int], None] = lambda _, __: None,
) -> list[dict[str, Any]]:
    """Play the cells that were not played yet; return all results in the order of the matrix.

    Args:
        description: the description of the tool.
        cells: cells of the matrix.
        results: the earlier results for this tool.
        workers: play the cells.
        on_progress: called with the number of played cells and the total.

    Raises:
        UsageError: a stored line does not fit, or a result cannot be stored.
        WorkersError: the workers cannot be reached or do not fit, or some cells were not played.
    """
    done = _kept(results, {cell.id: cell for cell in cells})
    todo = sorted([cell for cell in cells if cell.id not in done], key=lambda cell: cell.moment.at)
    on_progress(len(cells) - len(todo), len(cells))
    shared = _Shared(description)
    for number, (cell, played) in enumerate(workers.each(_play, shared, todo), start=1):
        done[cell.id] = played
        results.append(played)
        on_progress(len(cells) - len(todo) + number, len(cells))
    return [done[cell.id] for cell in cells if cell.id in done]


@contextmanager
def no_log() -> Iterator[None]:
    """Disable logging, since the cells cause deaths on purpose."""
    logging.disable()
    try:
        yield
    finally:
        logging.disable(logging.NOTSET)


class _Shared:
    """The data that every worker needs. Each worker keeps its undisturbed run and continues it to the moment of the
    next cell.
    """

    def __init__(self, description: Description) -> None:
        self._described, self._automata = description, ShippedAutomata.read(description)
        self._undisturbed: Undisturbed | None = None

    def run_until(self, at: int) -> None:
        """Play the undisturbed run until ``at`` (µs)."""
        if self._undisturbed is None or self._undisturbed.tool.at > at:
            self._undisturbed = Undisturbed(self._automata.of(self._described))
        self._undisturbed.script.run_until(at)

    def take(self) -> Undisturbed:
        """Return the run, which a cell consumes: the next one begins another, unless this process is a copy."""
        taken, self._undisturbed = self._undisturbed, None
        assert taken is not None
        return taken

    def __getstate__(self) -> dict[str, Any]:
        return vars(self) | {"_undisturbed": None}


def _play(shared: _Shared, cell: Cell) -> dict[str, Any]:
    with no_log():
        shared.run_until(cell.moment.at)
        return in_a_copy(lambda: CellRun(shared.take(), cell).played().as_json())


def in_a_copy(work: Callable[[], T]) -> T:
    """Return what ``work`` returns in a fork of this process, which leaves this process as it is.

    The work is done here if the fork dies or raises, and in any thread but the main one (a worker of a cluster): a
    lock that another thread holds would never be released in a fork.
    """
    if threading.current_thread() is not threading.main_thread():
        return work()
    fork = get_context("fork")
    here, there = fork.Pipe(duplex=False)
    copy = fork.Process(target=_send_result, args=(there, work))
    copy.start()
    there.close()
    with here, suppress(EOFError, OSError):
        result: T = here.recv()
        copy.join()
        return result
    copy.join()
    return work()


def _send_result(there: Connection, work: Callable[[], object]) -> None:
    with suppress(Exception):
        there.send(work())


def _kept(results: ResultsFolder, cells: dict[str, Cell]) -> dict[str, dict[str, Any]]:
    """Return the stored results by the id of their cell."""
    done: dict[str, dict[str, Any]] = {}
    for where, played in results.lines(_SHAPE):
        if wrong := _misfit(played, cells.get(played.id)):
            raise results.misfit(wrong, where)
        if played.id in done:
            raise results.misfit("its cell is in an earlier line, too.", where)
        done[played.id] = played.as_json()
    return done


def _misfit(played: Played, cell: Cell | None) -> str:
    """Return how a line contradicts its cell, or itself; "" if it does not. None: the cell is not requested."""
    if played.id != f"{played.fault} @ {played.moment} + {played.command}":
        return "fault, moment and command are not those of its id."
    if played.command not in WORDS or played.phase not in PHASES:
        return "its command or its phase is not known."
    if cell is not None and played.phase != cell.moment.phase:
        return f"its moment is in the phase {cell.moment.phase}."
    if not {played.outcome, *played.expected} <= _OUTCOMES:
        return "its outcome, or one that is expected, is not known."
    if played.explained == bool(played.objections) or (played.dropped and played.explained):
        return "it is explained, and there are objections, or the reverse."
    return ""
