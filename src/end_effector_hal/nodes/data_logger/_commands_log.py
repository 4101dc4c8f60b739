"""``commands.csv``: the commands of the Supervisor, written as they are given."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from end_effector_hal._closing import Closing
from end_effector_hal.errors import os_errors
from end_effector_hal.owned import open_owned
from end_effector_hal.vocabulary import Command

HEADER = "time_s,command\n"


class CommandsLog(Closing):
    """Writes a row per command: seconds since the start of the recording, the integer of Table II.

    Args:
        folder: of the recording; a file that is there is continued.
        seconds: from µs on the monotonic clock to the recording's time.

    Raises:
        UsageError: it cannot be written.
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

    def write(self, at: int, command: Command) -> None:
        """A command was given at ``at`` (µs); raises OSError, and it is written with the next one that can be."""
        with self._lock:
            self._file.write(f"{self._seconds(at):.6f},{int(command)}\n")

    def close(self) -> None:
        """Close the file; what cannot be written any more is lost."""
        with self._lock, suppress(OSError):
            self._file.close()
