"""How far the emulated board is, on standard error."""

from __future__ import annotations

import json
import os
import time
from pathlib import Path
from types import TracebackType
from typing import Self

from rich.console import Console
from rich.status import Status

TAIL = 4096


class BoardProgress:
    """One line that changes on a terminal, else one at the begin and one at the end.

    Args:
        console: where it is shown.
        title: such as ``nominal``.
        events: file of the testbench: its times are the board's.
    """

    def __init__(self, console: Console, title: str, events: Path) -> None:
        self._console, self._title, self._events = console, title, events
        self._begun = time.monotonic()
        self._line: Status | None = None

    def __enter__(self) -> Self:
        text = f"{self._title}: the emulated board starts"
        if self._console.is_terminal:
            self._line = self._console.status(text)
            self._line.start()
        else:
            self._console.print(text, highlight=False)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._line is not None:
            self._line.stop()
        self._console.print(self.text(), highlight=False)

    def update(self) -> None:
        """Show it as it is now."""
        if self._line is not None:
            self._line.update(self.text())

    def text(self) -> str:
        """For example ``nominal: 12.3 s of the board's time in 40 s``."""
        return f"{self._title}: {self.board_s():.1f} s of the board's time in {time.monotonic() - self._begun:.0f} s"

    def board_s(self) -> float:
        """How long the board has run, in its own time."""
        try:
            with self._events.open("rb") as file:
                file.seek(max(0, file.seek(0, os.SEEK_END) - TAIL))
                *_, last, _rest = file.read().split(b"\n")
            return float(json.loads(last)["at"]) / 1e6
        except (OSError, ValueError, KeyError):
            return 0.0
