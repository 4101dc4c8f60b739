"""All cells of a matrix, on all workers; what was played is kept, so that it goes on where it was stopped."""

from __future__ import annotations

import json
import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from end_effector_hal.description import Description
from end_effector_lab.workers import Workers

from ._cells import Cell
from ._kept_lines import kept_file, read_kept
from ._play import play

KEPT, HEADER = "cells.jsonl", "matrix.json"


def play_all(
    description: Description,
    cells: Sequence[Cell],
    folder: Path,
    *,
    workers: Workers,
    on_progress: Callable[[int, int], None] = lambda _, __: None,
) -> list[dict[str, Any]]:
    """Play the cells that were not played yet; all of them as they are kept, in the order of the matrix.

    Args:
        description: the tool.
        cells: of the matrix.
        folder: keeps what was played.
        workers: play them.
        on_progress: called with how many were played, and how many there are.

    Raises:
        UsageError: the folder cannot be written, or is that of another tool.
        WorkersError: they cannot be reached or do not fit, or some cells were not played.
    """
    kept = kept_file(folder, HEADER, KEPT, description, "matrix")
    done = {each["id"]: dict(each) for each in read_kept(kept)}
    todo = [cell for cell in cells if cell.id not in done]
    on_progress(len(cells) - len(todo), len(cells))
    with kept.open("a", encoding="utf-8") as file:
        for number, (cell, played) in enumerate(workers.each(_play, description, todo), start=1):
            done[cell.id] = played
            file.write(json.dumps(played) + "\n")
            file.flush()
            on_progress(len(cells) - len(todo) + number, len(cells))
    return [done[cell.id] for cell in cells if cell.id in done]


@contextmanager
def no_log() -> Iterator[None]:
    """Nothing is logged: who dies is what the cells are about."""
    logging.disable()
    try:
        yield
    finally:
        logging.disable(logging.NOTSET)


def _play(description: Description, cell: Cell) -> dict[str, Any]:
    with no_log():
        return play(description, cell).as_json()
