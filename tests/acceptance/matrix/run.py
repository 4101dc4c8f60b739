"""``make matrix-processes``: some cells of ``eehal matrix`` on real processes; each must end as in virtual time."""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import time
from collections import defaultdict
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import islice
from pathlib import Path
from random import Random
from tempfile import mkdtemp
from typing import NamedTuple

import click

from end_effector_hal.codecs import load_tool
from end_effector_hal.description import Description, profile_path
from end_effector_hal.errors import ReportedError
from end_effector_lab.trials import Cell, cells_of, moments, no_log, play_case
from tests.support.on_processes import play_on_processes

RANDOM = {
    "noise",
    "flips",
    "bursts",
    "lost-bytes",
    "doubled-bytes",
    "no-answers",
    "twice-answers",
    "wrong-answers",
}
"""Faults that come by chance: no two runs in real time are the same."""
TRIES = 3


class Row(NamedTuple):
    """A cell and its two endings.

    Attributes:
        virtual, real: how it ended in virtual time, and on real processes.
        same: whether the state and the active outputs are the same.
    """

    cell: str
    virtual: str
    real: str
    same: bool
    seconds: float


def playable(description: Description) -> list[Cell]:
    """Return the cells far from any event, without a restart at once: real processes cannot meet a millisecond.

    Raises:
        UsageError: the tool does not grip without a fault.
    """
    when = moments(description)
    far = {when[0].name, *(moment.name for moment in when if moment.name.endswith(", between"))}
    every = cells_of(description, when)
    return [
        cell for cell in every if not cell.at_once and cell.name not in RANDOM and cell.moment.name in far
    ]


def sample(cells: list[Cell], size: int, seed: int) -> list[Cell]:
    """Return ``size`` cells, with the same number of each fault; the same seed gives the same cells."""
    random, by_fault = Random(seed), defaultdict[str, list[Cell]](list)
    for cell in random.sample(cells, len(cells)):
        by_fault[cell.name].append(cell)

    def in_turns() -> Iterator[Cell]:
        while left := [each for each in by_fault.values() if each]:
            yield from (each.pop() for each in random.sample(left, len(left)))

    return list(islice(in_turns(), size))


def played(description: Description, cell: Cell, folder: Path) -> Row:
    """Play a cell in both ways; for real up to three times, since a busy machine is late."""
    begun = time.monotonic()
    trial = play_case(description, cell.case)
    virtual = trial.end
    assert virtual is not None
    real, same = "", False
    for attempt in range(TRIES):
        try:
            end = play_on_processes(description, cell.case, folder / str(attempt), lasts_s=trial.lasted_s)
            real, same = str(end), (end.state, end.active) == (virtual.state, virtual.active)
        except ReportedError as error:
            real = str(error)
        if same:
            break
    return Row(cell.id, str(virtual), real, same, time.monotonic() - begun)


def main() -> int:
    arguments = _arguments()
    description = load_tool(arguments.description)
    cells = playable(description)
    if arguments.cell:
        cells = [cell for cell in cells if arguments.cell in cell.id]
    else:
        cells = sample(cells, arguments.sample, arguments.seed)
    begun, folder, rows = time.monotonic(), Path(mkdtemp(prefix="eehal-matrix-")), list[Row]()
    with no_log(), ThreadPoolExecutor(arguments.systems) as systems:
        todo = ((description, cell, folder / str(number)) for number, cell in enumerate(cells))
        for row in systems.map(played, *zip(*todo, strict=True)):
            rows.append(row)
            told = row.real if row.same else f"{row.real} (virtual: {row.virtual})"
            mark = "same" if row.same else "FAIL"
            click.echo(f"{len(rows):3}/{len(cells)} {mark} {row.seconds:5.1f} s  {row.cell}: {told}")
    arguments.output.parent.mkdir(parents=True, exist_ok=True)
    arguments.output.write_text(
        json.dumps([row._asdict() for row in rows], indent=1) + "\n", encoding="utf-8"
    )
    same, took = sum(row.same for row in rows), time.monotonic() - begun
    click.echo(f"{same} of {len(cells)} cells end as in virtual time; {took:.0f} s; {arguments.output}")
    if same == len(cells):
        shutil.rmtree(folder, ignore_errors=True)
        return 0
    click.echo(f"logs: {folder}")
    return 1


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sample", type=int, default=50, metavar="N", help="cells (default 50)")
    parser.add_argument("--seed", type=int, default=0, help="of the choice (default 0)")
    parser.add_argument("--cell", default="", metavar="TEXT", help="the cells whose id has this text")
    parser.add_argument("--systems", type=int, default=3, metavar="N", help="systems at once (default 3)")
    parser.add_argument(
        "--description", type=Path, default=profile_path(), metavar="FILE", help="another tool"
    )
    parser.add_argument(
        "-o", "--output", type=Path, default=Path("runs/matrix-processes.json"), metavar="FILE"
    )
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
