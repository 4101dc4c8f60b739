"""Track the rows of a recording that could not be written."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from end_effector_hal.errors import ReportedError


class Losses:
    """The write failures of one recording folder; not thread-safe.

    Attributes:
        failing: files that could not be written at the last attempt, with the reason.
        gaps: sentences about missing rows, one for each interval, for run.json.
        info_due: whether run.json must be written.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self.failing: dict[str, str] = {}
        self.gaps: list[str] = []
        self.info_due = False
        self._since_s: float | None = None
        self._rows = 0
        self._why = ""

    def write(self, name: str, time_s: float, write: Callable[[], bool], *, again: bool = False) -> bool:
        """Write a row of time ``time_s``; return False if the row was not needed or cannot be written.

        ``write`` returns whether it has proven that the file can be written; ``again``: the row has already been
        counted as lost.
        """
        try:
            written = write()
        except (ReportedError, OSError) as error:
            self._rows += not again
            self.fail(name, time_s, error)
            return False
        if written:
            self.failing.pop(name, None)
        return written

    def fail(self, name: str, time_s: float, error: Exception) -> None:
        """Note that a file could not be written."""
        self._why = self._why or (error.what if isinstance(error, ReportedError) else str(error))
        self._since_s = time_s if self._since_s is None else self._since_s
        self.failing[name] = str(error)

    def over(self, time_s: float) -> bool:
        """Return whether a loss has occurred since the last call; if rows were lost, add a sentence to :attr:`gaps`."""
        if self._since_s is None:
            return False
        if self._rows:
            span = f"From {self._since_s:.3f} s to {time_s:.3f} s"
            self.gaps.append(f"{span} {self._rows} rows of this recording could not be written. {self._why}")
        self._since_s, self._rows, self._why = None, 0, ""
        return True

    def complain(self) -> None:
        """Raise ReportedError, with the text of the first failure, while a file cannot be written."""
        if self.failing:
            what = f"Rows of the recording cannot be written; writing is retried: {self._why}"
            raise ReportedError(what, where=str(self._folder))
