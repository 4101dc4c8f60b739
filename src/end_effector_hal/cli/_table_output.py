"""Tables that commands print."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.table import Table

LEAST, MOST = 120, 400
"""Columns where it is no terminal: a file has no width of its own, and a row stays in one line."""


def print_table(table: Table) -> None:
    """Print a table. What stands in it is the user's: none of it is markup."""
    from rich.console import Console

    console = Console(highlight=False, markup=False, emoji=False)
    if not console.is_terminal:
        wide = console.options.update(width=MOST)
        console.width = max(LEAST, console.measure(table, options=wide).maximum)
    console.print(table)
