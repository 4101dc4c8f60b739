"""What is going on, on standard error: one line that changes on a terminal, else a line per change."""

from __future__ import annotations

import threading
import time
from pathlib import Path
from types import TracebackType
from typing import Self

from rich.console import Console
from rich.status import Status

from end_effector_hal.kinds import recorded_kind
from end_effector_hal.recording import RunInfo
from end_effector_hal.vocabulary import display_name

from ._last_state import last_row

PERIOD_S = 0.2


class Progress:
    """Follows the recording of one scenario while it is played.

    Args:
        console: where it is shown.
        title: such as ``[1/3] nominal``.
        states: the recording.
        info: kinds of its actuators, for their words.
    """

    def __init__(self, console: Console, title: str, states: Path, info: RunInfo) -> None:
        self._console, self._title, self._states, self._info = console, title, states, info
        self._line: Status | None = None
        self._end = threading.Event()
        self._doing = "starting"
        self._thread = threading.Thread(target=self._follow, name="progress", daemon=True)
        self._begun = time.monotonic()

    def __enter__(self) -> Self:
        if self._console.is_terminal:
            self._line = self._console.status(f"{self._title}: starting")
            self._line.start()
        else:
            self._console.print(f"{self._title}: starting", highlight=False)
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._end.set()
        self._thread.join()
        if self._line is not None:
            self._line.stop()

    def _follow(self) -> None:
        while not self._end.wait(PERIOD_S):
            doing = self.describe()
            if self._line is not None:
                self._line.update(f"{self._title}: {doing}  {time.monotonic() - self._begun:.0f} s")
            elif doing != self._doing:
                self._console.print(f"{self._title}: {doing}", highlight=False)
            self._doing = doing

    def describe(self) -> str:
        """For example ``GRIPPING, Cylinder PENDING EXTEND``."""
        found = last_row(self._states)
        if found is None:
            return "starting"
        log, row = found
        words = [row.end_effector.label]
        words += [
            f"{display_name(name)} {recorded_kind(name, self._info.actuators).states(value).label}"
            for name, value in zip(log.actuators, row.actuators, strict=True)
            if value
        ]
        return ", ".join(words)
