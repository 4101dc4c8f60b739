"""``commands.csv``: the commands that the Supervisor gives, written at once."""

from __future__ import annotations

import csv
import os
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from end_effector_hal._closing import Closing
from end_effector_hal.errors import os_errors
from end_effector_hal.owned import open_owned
from end_effector_hal.vocabulary import LONGEST_NAME, Command, printable

HEADER = "time_s,command,part\n"


class CommandsLog(Closing):
    """Writes one row per command: seconds since the start of the recording, the integer of Table II, and the name of
    the part that a grip is for.

    Args:
        folder: the folder of the recording; an existing file is continued.
        seconds: converts µs on the monotonic clock to the recording's time.

    Raises:
        UsageError: the file cannot be written.
    """

    def __init__(self, folder: Path, seconds: Callable[[int], float]) -> None:
        path = folder / "commands.csv"
        self._seconds, self._lock = seconds, threading.Lock()
        with os_errors("Cannot be written", path):
            fd = open_owned(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
            self._file = os.fdopen(
                fd, "a", encoding="utf-8", buffering=1
            )  # a kill loses the last row at most
            if self._file.tell() == 0:
                self._file.write(HEADER)
            self._rows = csv.writer(self._file, lineterminator="\n")

    def write(self, at: int, command: Command, part: str) -> None:
        """Write a command that was given at ``at`` (µs); after an OSError the row is written with the next one."""
        row = (f"{self._seconds(at):.6f}", int(command), printable(part, LONGEST_NAME))
        with self._lock:
            self._rows.writerow(row)

    def close(self) -> None:
        """Close the file; rows that cannot be written any more are lost."""
        with self._lock, suppress(OSError):
            self._file.close()
