"""The output of the commands: JSON (every object names the version of its schema), tables, and progress."""

from __future__ import annotations

import errno
import json
import sys
import threading
import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Self

import click

if TYPE_CHECKING:
    from rich.table import Table


LOST = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EBADF)
"""Errors of an output that goes to a disk without room for it, or was closed before the start."""
SCHEMA_VERSION = 1
"""Increased when a field is removed or changes its meaning; new fields do not change it."""


def json_text(document: Mapping[str, object], *, indent: int | None = None) -> str:
    """Return an object as JSON text with its ``schema_version`` first."""
    return json.dumps({"schema_version": SCHEMA_VERSION, **document}, indent=indent, ensure_ascii=False)


def print_document(document: Mapping[str, object]) -> None:
    """Print the object that is the answer of a command, on several lines."""
    click.echo(json_text(document, indent=2))


def print_line(**content: object) -> None:
    """Print one object of a sequence on a line of its own."""
    click.echo(json_text(content))


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


FIRST_S, EVERY_S = 1.0, 0.2
"""Time before the first message on a terminal, and interval of its updates, s. A shorter operation is not mentioned."""
LINE_S = 30.0
"""Interval of the lines in a log that is no terminal, such as that of a build, s."""


class Progress:
    """A line on stderr that is overwritten while an operation runs. It appears after one second and is removed at the
    end. Without a terminal a line is printed every 30 s.

    Args:
        what: the running operation.
        shown: whether the command prints for a person and not JSON.
    """

    def __init__(self, what: str, *, shown: bool = True) -> None:
        self._what, self._shown, self._overwrites = what, shown, sys.stderr.isatty()
        self._begun = time.monotonic()
        self._lock, self._left, self._visible = threading.Lock(), threading.Event(), False
        self._thread = threading.Thread(target=self._run, name="progress", daemon=True)

    def __call__(self, what: str) -> None:
        """Replace the text that describes the operation."""
        self._what = what

    def clear(self) -> None:
        """Remove the line, so that other text can be printed."""
        with self._lock:
            if self._visible:
                click.echo("\r\x1b[K", err=True, nl=False)
                self._visible = False

    def __enter__(self) -> Self:
        if self._shown:
            self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._left.set()
        if self._shown:
            self._thread.join()
        self.clear()

    def _run(self) -> None:
        wait = FIRST_S if self._overwrites else LINE_S
        while not self._left.wait(wait):
            with self._lock:
                said = f"{self._what}, {time.monotonic() - self._begun:.0f} s"
                click.echo(f"\r\x1b[K{said}" if self._overwrites else said, err=True, nl=not self._overwrites)
                self._visible = self._overwrites
            wait = EVERY_S if self._overwrites else LINE_S
