"""All cells of a matrix, on all processors; what was played is kept, so that it goes on where it was stopped."""

from __future__ import annotations

import json
import logging
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from itertools import islice
from pathlib import Path
from typing import Any

from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_hal.recording import product_version

from ._cells import Cell
from ._play import play

KEPT, HEADER = "cells.jsonl", "matrix.json"
CHUNK = 8
"""Cells that a worker gets at once."""
_worker: dict[str, Description] = {}


def play_all(
    description: Description,
    cells: Sequence[Cell],
    folder: Path,
    *,
    jobs: int,
    on_progress: Callable[[int, int], None] = lambda _, __: None,
) -> list[dict[str, Any]]:
    """Play the cells that were not played yet; all of them as they are kept, in the order of the matrix.

    Args:
        description: the tool.
        cells: of the matrix.
        folder: keeps what was played.
        jobs: processes.
        on_progress: called with how many were played, and how many there are.

    Raises:
        UsageError: the folder cannot be written, or is that of another tool.
    """
    kept = _open(folder, description)
    done = _read(kept)
    todo = [cell for cell in cells if cell.id not in done]
    on_progress(len(cells) - len(todo), len(cells))
    with kept.open("a", encoding="utf-8") as file:
        for played in _played(description, todo, jobs):
            for each in played:
                done[each["id"]] = each
                file.write(json.dumps(each) + "\n")
            file.flush()
            on_progress(sum(cell.id in done for cell in cells), len(cells))
    return [done[cell.id] for cell in cells if cell.id in done]


def _played(description: Description, todo: Sequence[Cell], jobs: int) -> Iterator[list[dict[str, Any]]]:
    chunks = iter([todo[at : at + CHUNK] for at in range(0, len(todo), CHUNK)])
    if jobs == 1:
        with no_log():
            yield from ([play(description, cell).as_json() for cell in each] for each in chunks)
        return
    with ProcessPoolExecutor(jobs, initializer=_begin, initargs=(description,)) as pool:
        waiting: set[Future[list[dict[str, Any]]]] = {
            pool.submit(_chunk, each) for each in islice(chunks, 2 * jobs)
        }
        while waiting:
            finished, waiting = wait(waiting, return_when=FIRST_COMPLETED)
            waiting |= {pool.submit(_chunk, each) for each in islice(chunks, len(finished))}
            for each in finished:
                yield each.result()


@contextmanager
def no_log() -> Iterator[None]:
    """Nothing is logged: who dies is what the cells are about."""
    logging.disable()
    try:
        yield
    finally:
        logging.disable(logging.NOTSET)


def _begin(description: Description) -> None:
    logging.disable()
    _worker["tool"] = description


def _chunk(cells: Sequence[Cell]) -> list[dict[str, Any]]:
    return [play(_worker["tool"], cell).as_json() for cell in cells]


def _open(folder: Path, description: Description) -> Path:
    """The file of what was played."""
    header, mark = folder / HEADER, {"tool": description.name, "description": description.fingerprint()}
    mark["version"] = product_version()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if header.exists() and json.loads(header.read_text(encoding="utf-8")) != mark:
            raise UsageError(
                "This folder has the matrix of another tool, or of another version of its description.",
                where=str(folder), todo="Name another folder.",
            )  # fmt: skip
        header.write_text(json.dumps(mark) + "\n", encoding="utf-8")
        (folder / KEPT).touch()
    except (OSError, ValueError) as error:
        raise UsageError(f"The folder cannot be used: {error}.", where=str(folder)) from None
    return folder / KEPT


def _read(kept: Path) -> dict[str, dict[str, Any]]:
    """By the id of the cell; a last line that was cut off by a kill is played again."""
    done: dict[str, dict[str, Any]] = {}
    text = kept.read_text(encoding="utf-8")
    whole, _, torn = text.rpartition("\n")
    for line in whole.splitlines():
        each = json.loads(line)
        done[each["id"]] = each
    if torn:
        kept.write_text(whole + "\n" if whole else "", encoding="utf-8")
    return done
