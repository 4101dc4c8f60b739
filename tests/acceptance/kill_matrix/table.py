"""The table of the matrix."""

from __future__ import annotations

from collections.abc import Iterable

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from tests.acceptance.kill_matrix.cells import parts
from tests.acceptance.kill_matrix.play import Row


def show(console: Console, rows: Iterable[Row]) -> None:
    """A row per cell."""
    table = Table(
        "process", "signal", "state", "expected", "observed", "", title="Kill matrix", pad_edge=False
    )
    for row in rows:
        verdict = "[red]FAIL[/]" if not row.ok else "[yellow]ok, 2nd[/]" if row.before else "[green]ok[/]"
        table.add_row(*parts(row.cell), escape(row.expected), escape(row.observed), verdict)
    console.print(table)
