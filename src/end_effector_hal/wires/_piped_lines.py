"""Lines of an input that nobody types, such as a pipe."""

from __future__ import annotations

import os
import select

LONGEST_LINE = 65_536
"""Longest line, bytes; what follows counts as the next line."""
SIGNALS_S = 0.5
"""Interval at which a wait for a line looks for a signal, s."""


class PipedLines:
    """Reads an input line by line, and hears signals while it waits.

    ``input`` and ``readline`` do not: a signal that arrives just before they block waits for the next line.

    Args:
        fd: the input.
    """

    def __init__(self, fd: int) -> None:
        self._fd, self._unread = fd, b""

    def next(self) -> str | None:
        """Return the next line, without its ends; None: the input has ended. The last line may lack its newline."""
        while b"\n" not in self._unread and len(self._unread) < LONGEST_LINE:
            try:
                ready = select.select([self._fd], [], [], SIGNALS_S)[0]
                read = os.read(self._fd, LONGEST_LINE) if ready else None
            except (OSError, ValueError):  # it is closed, or a terminal in which another program is in front
                read = b""
            if read == b"":
                break
            self._unread += read or b""
        if not self._unread:
            return None
        line, _, self._unread = self._unread.partition(b"\n")
        return line.decode(errors="replace").strip()
