"""Shows the progress on standard error: one changing line on a terminal, else one line per change."""

from __future__ import annotations

import os
import threading
import time
from pathlib import Path
from typing import Self

from rich.console import Console
from rich.status import Status

from end_effector_hal.errors import UsageError
from end_effector_hal.kinds import recorded_kind
from end_effector_hal.recording import RunInfo, StatesLog, StatesRow, read_states
from end_effector_hal.vocabulary import EndEffectorState, display_name


def _log_of(path: Path) -> StatesLog | None:
    """Return the recording so far; None if it is still empty."""
    if not path.exists() or os.path.getsize(path) == 0:
        return None
    try:
        return read_states(path)
    except UsageError:
        return None  # its header is being written


def last_state(path: Path) -> EndEffectorState | None:
    """Return the newest state of the end-effector; None if nothing is recorded yet."""
    log = _log_of(path)
    return log.rows[-1].end_effector if log and log.rows else None


PERIOD_S = 0.2


class StatusLine:
    """A changing line on a terminal; elsewhere it is printed once.

    Args:
        console: where it is shown.
        title: its beginning, such as ``[1/3] nominal``.
        begin: its first text.
    """

    def __init__(self, console: Console, title: str, begin: str) -> None:
        self.console, self.title, self._begin = console, title, begin
        self._line: Status | None = None
        self.begun = time.monotonic()

    def __enter__(self) -> Self:
        text = f"{self.title}: {self._begin}"
        if self.console.is_terminal:
            self._line = self.console.status(text)
            self._line.start()
        else:
            self.console.print(text, highlight=False)
        return self

    def __exit__(self, *_: object) -> None:
        if self._line is not None:
            self._line.stop()

    def show(self, text: str) -> bool:
        """Change the line; return False if that is not possible."""
        if self._line is None:
            return False
        self._line.update(f"{self.title}: {text}")
        return True


class Progress(StatusLine):
    """Shows the progress of the recording of one scenario.

    Args:
        console, title: see `StatusLine`.
        states: the recording.
        info: the kinds of its actuators, for their words.
    """

    def __init__(self, console: Console, title: str, states: Path, info: RunInfo) -> None:
        self._doing = "starting"
        super().__init__(console, title, self._doing)
        self._states, self._info = states, info
        self._shown = 0
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._follow, name="progress", daemon=True)

    def __enter__(self) -> Self:
        super().__enter__()
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._end.set()
        self._thread.join()
        super().__exit__()

    def _follow(self) -> None:
        while not self._end.wait(PERIOD_S):
            for doing in self.news():
                if self._line is None and doing != self._doing:
                    self.console.print(f"{self.title}: {doing}", highlight=False)
                self._doing = doing
            self.show(f"{self._doing}  {time.monotonic() - self.begun:.0f} s")

    def news(self) -> list[str]:
        """Return all states since the last call, including momentary ones such as a GRIP_ERROR before a release."""
        log = _log_of(self._states)
        if log is None:
            return []
        rows, self._shown = log.rows[self._shown :], len(log.rows)
        return [self._describe(log, row) for row in rows]

    def _describe(self, log: StatesLog, row: StatesRow) -> str:
        """Return a row as text, for example ``GRIPPING, Cylinder PENDING EXTEND``."""
        words = [row.end_effector.label]
        words += [
            f"{display_name(name)} {recorded_kind(name, self._info.actuators).states(value).label}"
            for name, value in zip(log.actuators, row.actuators, strict=True)
            if value
        ]
        return ", ".join(words)
