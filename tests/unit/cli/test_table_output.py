"""Tables where the output is no terminal: a row is a line, and what is in it is no markup."""

from __future__ import annotations

import pytest
from rich.table import Table

from end_effector_hal.cli._output import print_table


def test_a_long_row_stays_in_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    table = Table("run", "replay", box=None, pad_edge=False)
    name = "a" * 150 + "[b]"
    table.add_row(name, "the same as recorded")
    print_table(table)
    head, row = capsys.readouterr().out.splitlines()
    assert head.split() == ["run", "replay"]
    assert row.split(maxsplit=1) == [name, "the same as recorded"]
