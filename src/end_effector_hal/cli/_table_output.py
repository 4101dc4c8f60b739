"""Prints tables for the commands."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.table import Table

LEAST, MOST = 120, 400
"""Smallest and largest width without a terminal, columns: a file has no width of its own, and a row must stay on one
line.
"""


def print_table(table: Table) -> None:
    """Print a table. Its cells contain texts of the user, so that nothing in them is read as markup."""
    from rich.console import Console

    console = Console(highlight=False, markup=False, emoji=False)
    if not console.is_terminal:
        wide = console.options.update(width=MOST)
        console.width = max(LEAST, console.measure(table, options=wide).maximum)
    console.print(table)
