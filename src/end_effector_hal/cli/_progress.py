"""Says on a terminal that something takes its time, and how long already."""

from __future__ import annotations

import sys
import threading
import time
from typing import Self

import click

FIRST_S = 1.0
"""What takes less is not mentioned."""
EVERY_S = 0.2


class Progress:
    """A line on stderr that is overwritten, from one second on; gone when it is left. Nothing where nobody looks.

    Args:
        what: is being done.
        shown: whether the command prints for a person, no JSON; it must be a terminal as well.
    """

    def __init__(self, what: str, *, shown: bool = True) -> None:
        self._what, self._shown = what, shown and sys.stderr.isatty()
        self._begun = time.monotonic()
        self._lock, self._left, self._visible = threading.Lock(), threading.Event(), False
        self._thread = threading.Thread(target=self._run, name="progress", daemon=True)

    def __call__(self, what: str) -> None:
        """Something else is being done, or more of it."""
        self._what = what

    def clear(self) -> None:
        """Take the line away before something else is printed."""
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
        wait = FIRST_S
        while not self._left.wait(wait):
            with self._lock:
                seconds = time.monotonic() - self._begun
                click.echo(f"\r\x1b[K{self._what}, {seconds:.0f} s", err=True, nl=False)
                self._visible = True
            wait = EVERY_S
