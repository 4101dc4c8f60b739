"""Shows that an operation takes long, and for how long it has been running."""

from __future__ import annotations

import sys
import threading
import time
from typing import Self

import click

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
