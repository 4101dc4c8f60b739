"""All cells of a matrix, on all workers; what was played is kept, so that it goes on where it was stopped."""

from __future__ import annotations

import json
import logging
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from end_effector_hal.description import Description
from end_effector_hal.errors import UsageError
from end_effector_hal.recording import product_version
from end_effector_lab.workers import ShippedAutomata, Workers

from ._cells import Cell
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
    kept = _open(folder, description)
    done = _read(kept)
    todo = [cell for cell in cells if cell.id not in done]
    on_progress(len(cells) - len(todo), len(cells))
    with kept.open("a", encoding="utf-8") as file:
        shared = description, ShippedAutomata(description)
        for number, (cell, played) in enumerate(workers.each(_play, shared, todo), start=1):
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


def _play(shared: tuple[Description, ShippedAutomata], cell: Cell) -> dict[str, Any]:
    description, automata = shared
    with no_log():
        return play(automata.of(description), cell).as_json()


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
