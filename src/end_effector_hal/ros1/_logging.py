"""The log of a node in ROS 1: to the console and to /rosout, in a thread of its own, at a bounded rate.

rospy writes to files and to /rosout in the thread that logs: a line must not stand between a status and its message.
"""

from __future__ import annotations

import logging
import queue
import threading
import time
from collections.abc import Callable

import rospy

from end_effector_hal.vocabulary import printable

_LEVELS = (
    (logging.ERROR, rospy.logerr),
    (logging.WARNING, rospy.logwarn),
    (logging.INFO, rospy.loginfo),
    (logging.DEBUG, rospy.logdebug),
)
BURST, PER_S = 50, 5.0
"""Lines at once, and how many a second in the long run; for INFO and for what is worse each."""
LONGEST = 10_000
"""Characters of a line."""
FLUSH_S = 1.0

_Line = Callable[[], None]


class Allowance:
    """How many lines may be written now; refused ones are counted until the next that may.

    Args:
        clock: seconds.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock, self._left, self._at = clock, float(BURST), clock()
        self._refused = 0

    def use(self) -> int | None:
        """Use one line; None: there is none left. Else how many were refused since the last one."""
        now = self._clock()
        self._left, self._at = min(float(BURST), self._left + (now - self._at) * PER_S), now
        if self._left < 1.0:
            self._refused += 1
            return None
        self._left -= 1.0
        refused, self._refused = self._refused, 0
        return refused


class RosLog(logging.Handler):
    """Passes records to rospy, in their order."""

    def __init__(self) -> None:
        super().__init__()
        self._common, self._worse = Allowance(), Allowance()
        self._lines: queue.SimpleQueue[_Line | None] = queue.SimpleQueue()
        self._ended = False
        self._thread = threading.Thread(target=self._run, name="log", daemon=True)
        self._thread.start()

    def emit(self, record: logging.LogRecord) -> None:  # called under the handler's lock
        """Have a record written; it never waits before :meth:`end`."""
        refused = (self._common if record.levelno <= logging.INFO else self._worse).use()
        if refused is None:
            return
        if refused:
            self._put(
                lambda: rospy.logwarn(
                    "%d lines were left out: there were more than %g a second.", refused, PER_S
                )
            )
        lines = (printable(line, LONGEST) for line in self.format(record)[:LONGEST].splitlines())
        # the console shows no name, and several nodes share a terminal
        text = f"{rospy.get_name()}: " + "\n".join(lines)
        log = next((log for level, log in _LEVELS if record.levelno >= level), rospy.logdebug)
        self._put(lambda: log("%s", text))

    def end(self) -> None:
        """Write what still waits, for a second at most; from now on a record is written in its own thread."""
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


def node_log(node: str) -> tuple[logging.Logger, RosLog]:
    """The logger of a node, and its handler; call it after ``init_node``, which replaces those of the root logger."""
    handler = RosLog()
    top = logging.getLogger("end_effector_hal")
    top.propagate = False
    top.setLevel(logging.INFO)
    top.handlers = [handler]
    return logging.getLogger(f"end_effector_hal.{node}"), handler
