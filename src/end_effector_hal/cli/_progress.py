"""Says that something takes its time, and how long already."""

from __future__ import annotations

import sys
import threading
import time
from typing import Self

import click

FIRST_S, EVERY_S = 1.0, 0.2
"""On a terminal: what takes less is not mentioned."""
LINE_S = 30.0
"""Elsewhere, in the log of a build: a line each."""


class Progress:
    """A line on stderr that is overwritten, from one second on; gone when it is left. No terminal: a line now and then.

    Args:
        what: is being done.
        shown: whether the command prints for a person, no JSON.
    """

    def __init__(self, what: str, *, shown: bool = True) -> None:
        self._what, self._shown, self._overwrites = what, shown, sys.stderr.isatty()
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
        wait = FIRST_S if self._overwrites else LINE_S
        while not self._left.wait(wait):
            with self._lock:
                said = f"{self._what}, {time.monotonic() - self._begun:.0f} s"
                click.echo(f"\r\x1b[K{said}" if self._overwrites else said, err=True, nl=not self._overwrites)
                self._visible = self._overwrites
            wait = EVERY_S if self._overwrites else LINE_S
