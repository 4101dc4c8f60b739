"""The interlock table: every interlock against the three doors. ``make interlocks`` prints it."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from rich.console import Console
from rich.table import Table

from tests.acceptance.interlocks.doors import CELLS, DOORS, INTERLOCKS, Cell
from tests.acceptance.interlocks.rig import Rig

pytestmark = [pytest.mark.wall, pytest.mark.timeout(60)]
VIOLATED = [cell for cell in CELLS if cell.violate]


@pytest.fixture(scope="module")
def said() -> Iterator[dict[Cell, str]]:
    """What each door answered; printed at the end."""
    answers: dict[Cell, str] = {}
    yield answers
    table = Table("", *DOORS, show_lines=True)
    for interlock in INTERLOCKS:
        row = [
            "\n".join(
                answers.get(cell, f"not applicable: {cell.said}" if cell.violate is None else "not run")
                for cell in CELLS
                if (cell.interlock, cell.door) == (interlock, door)
            )
            for door in DOORS
        ]
        table.add_row(interlock, *row)
    Console(width=160).print(table)


def test_each_interlock_has_an_answer_at_each_door() -> None:
    there = {(cell.interlock, cell.door) for cell in CELLS}
    assert there == {(interlock, door) for interlock in INTERLOCKS for door in DOORS}


@pytest.mark.parametrize("cell", VIOLATED, ids=[f"{cell.interlock}-{cell.door}" for cell in VIOLATED])
def test_it_is_refused_in_words(cell: Cell, tmp_path: Path, said: dict[Cell, str]) -> None:
    assert cell.violate
    # at the socket a hand writes the lines; only where a held part is concerned does the program have them
    program = cell.door != "socket" or cell.interlock == "IL-09"
    with Rig(tmp_path, program=program) as rig:
        before = dict(rig.arbiter.levels())
        answer = cell.violate(rig)
        said[cell] = answer
        assert re.search(cell.said, answer), answer
        assert before == dict.fromkeys(before, False)
