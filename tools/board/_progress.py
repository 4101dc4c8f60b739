"""The progress of the emulated board, on standard error."""

from __future__ import annotations

import json
import os
import time
from pathlib import Path

from rich.console import Console

from end_effector_lab.demo import StatusLine

TAIL = 4096


class BoardProgress(StatusLine):
    """Shows one changing line on a terminal, else one line at the beginning and one at the end.

    Args:
        console: the output.
        title: a title such as ``nominal``.
        events: file of the testbench, whose times are the board's.
    """

    def __init__(self, console: Console, title: str, events: Path) -> None:
        super().__init__(console, title, "the emulated board starts")
        self._events = events

    def __exit__(self, *_: object) -> None:
        super().__exit__()
        self.console.print(f"{self.title}: {self.text()}", highlight=False)

    def update(self) -> None:
        """Show the present progress."""
        self.show(self.text())

    def text(self) -> str:
        """Return a text such as ``12.3 s of the board's time in 40 s``."""
        return f"{self.board_s():.1f} s of the board's time in {time.monotonic() - self.begun:.0f} s"

    def board_s(self) -> float:
        """Return how long the board has run, in its own time."""
        try:
            with self._events.open("rb") as file:
                file.seek(max(0, file.seek(0, os.SEEK_END) - TAIL))
                *_, last, _rest = file.read().split(b"\n")
            return float(json.loads(last)["at"]) / 1e6
        except (OSError, ValueError, KeyError):
            return 0.0
