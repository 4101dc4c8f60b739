"""Logs of the core, in ROS's way: to the console and to /rosout, at a bounded rate."""

from __future__ import annotations

import logging
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


class Allowance:
    """How many lines may be written now; what is refused is counted until the next that may.

    Args:
        clock: seconds.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock, self._left, self._at = clock, float(BURST), clock()
        self._refused = 0

    def take(self) -> int | None:
        """Take one; None: there is none left. Else how many were refused since the last one."""
        now = self._clock()
        self._left, self._at = min(float(BURST), self._left + (now - self._at) * PER_S), now
        if self._left < 1.0:
            self._refused += 1
            return None
        self._left -= 1.0
        refused, self._refused = self._refused, 0
        return refused


class _ToRos(logging.Handler):
    def __init__(self) -> None:
        super().__init__()
        self._told, self._worse = Allowance(), Allowance()

    def emit(self, record: logging.LogRecord) -> None:  # called under the handler's lock
        refused = (self._told if record.levelno <= logging.INFO else self._worse).take()
        if refused is None:
            return
        if refused:
            rospy.logwarn("%d lines were left out: there were more than %g a second.", refused, PER_S)
        lines = (printable(line, LONGEST) for line in self.format(record)[:LONGEST].splitlines())
        # the console shows no name, and several nodes share a terminal
        text = f"{rospy.get_name()}: " + "\n".join(lines)
        for level, log in _LEVELS:
            if record.levelno >= level:
                log("%s", text)
                return


def node_logger(node: str) -> logging.Logger:
    """The node's logger. Call it after ``init_node``, which replaces the handlers of the root logger."""
    top = logging.getLogger("end_effector_hal")
    top.propagate = False
    top.setLevel(logging.INFO)
    top.handlers = [_ToRos()]
    return logging.getLogger(f"end_effector_hal.{node}")
