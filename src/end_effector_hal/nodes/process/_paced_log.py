"""The log of a node: written in a thread of its own, at a limited rate.

ROS writes to files, to a terminal and to /rosout in the thread that logs: a line must not delay the message of a
status.
"""

from __future__ import annotations

import logging
import queue
import threading
import time
from collections.abc import Callable

from end_effector_hal.vocabulary import printable

BURST, PER_S = 50, 5.0
"""Maximum number of lines at once, and per second in the long run; counted separately for INFO and for
higher levels.
"""
LONGEST = 10_000
"""Maximum length of a line, characters."""
FLUSH_S = 1.0

_Line = Callable[[], None]


class Allowance:
    """The number of lines that may be written now; refused lines are counted until the next one that may.

    Args:
        clock: returns the time, s.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock, self._left, self._at = clock, float(BURST), clock()
        self._refused = 0

    def use(self) -> int | None:
        """Use one line, and return how many were refused since the last one; None: there is none left."""
        now = self._clock()
        self._left, self._at = min(float(BURST), self._left + (now - self._at) * PER_S), now
        if self._left < 1.0:
            self._refused += 1
            return None
        self._left -= 1.0
        refused, self._refused = self._refused, 0
        return refused


class PacedLog(logging.Handler):
    """Passes records to a writer, in their order.

    Args:
        write: writes a text at a level of `logging`; it may wait.
    """

    def __init__(self, write: Callable[[int, str], None]) -> None:
        super().__init__()
        self._write = write
        self._common, self._worse = Allowance(), Allowance()
        self._lines: queue.SimpleQueue[_Line | None] = queue.SimpleQueue()
        self._ended = False
        self._thread = threading.Thread(target=self._run, name="log", daemon=True)
        self._thread.start()

    def emit(self, record: logging.LogRecord) -> None:  # called under the handler's lock
        """Queue a record for the writer; never waits before :meth:`end`."""
        refused = (self._common if record.levelno <= logging.INFO else self._worse).use()
        if refused is None:
            return
        if refused:
            left_out = f"{refused} lines were left out: there were more than {PER_S:g} a second."
            self._put(lambda: self._write(logging.WARNING, left_out))
        text = "\n".join(printable(line, LONGEST) for line in self.format(record)[:LONGEST].splitlines())
        self._put(lambda: self._write(record.levelno, text))

    def end(self) -> None:
        """Write the waiting lines, for a second at most; a later record is written in the thread that logs it."""
        self.acquire()
        self._ended = True
        self.release()
        self._lines.put(None)
        self._thread.join(FLUSH_S)

    def _put(self, line: _Line) -> None:
        if not self._ended:
            self._lines.put(line)
            return
        self._thread.join(FLUSH_S)
        line()

    def _run(self) -> None:
        while line := self._lines.get():
            line()


def node_log(node: str, write: Callable[[int, str], None]) -> tuple[logging.Logger, PacedLog]:
    """Return the logger of a node, and its handler; other records of the package go to the first node of
    the process.
    """
    handler = PacedLog(write)
    top, log = logging.getLogger("end_effector_hal"), logging.getLogger(f"end_effector_hal.{node}")
    top.propagate = log.propagate = False
    top.setLevel(logging.INFO)
    top.handlers = top.handlers or [handler]
    log.handlers = [handler]
    return log, handler
