"""A process of ROS 2 with one context, and one end: by a signal or by an error."""

from __future__ import annotations

import signal
from collections.abc import Sequence
from types import FrameType

import rclpy
from rclpy.context import Context
from rclpy.signals import SignalHandlerOptions

from end_effector_hal.errors import ReportedError, RosError, UsageError
from end_effector_hal.nodes.process import ProcessEnd, leave_within

LONGEST_END_S = 15.0
"""Longest time for an end in good order, s; longer than all its parts together."""
MIDDLEWARE_S = 5
"""Longest wait for the middleware to end, s.

Fast DDS may deadlock when processes that communicate with each other end at the same time (eProsima/Fast-DDS#6193).
"""


class Process:
    """Works until a signal comes, or a part of it fails.

    Args:
        argv: arguments of the program, with those after ``--ros-args``.

    Raises:
        UsageError: an argument is not valid for ROS 2.
        RosError: ROS 2 cannot be started.
    """

    def __init__(self, argv: Sequence[str]) -> None:
        self.context = Context()
        try:
            rclpy.init(args=list(argv), context=self.context, signal_handler_options=SignalHandlerOptions.NO)
        except Exception as error:  # noqa: BLE001 rclpy has a class for each part of it
            if "argument" in str(error).lower():
                why = str(error).partition(", at ")[0]
                raise UsageError(why, todo="Such as: --ros-args -p profile:=verdin_gripper") from None
            todo = "`eehal doctor --only ros` checks the installation."
            raise RosError(f"ROS 2 cannot be started: {error}.", todo=todo) from None
        self._end = ProcessEnd(LONGEST_END_S)
        self.end, self.wait = self._end.begin, self._end.wait
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._on_signal)

    @property
    def ending(self) -> bool:
        """Whether the end has begun."""
        return self._end.begun

    def fail(self, error: ReportedError) -> None:
        """End with an error, so that the launcher restarts this process; callable from any thread."""
        if self._end.fail(error):
            self._end.begin()

    def bound_middleware(self) -> None:
        """Exit the process after `MIDDLEWARE_S` if the middleware, which ends last, hangs."""
        if self.ending:
            leave_within(MIDDLEWARE_S, self._end.exit_code)

    def close(self) -> None:
        """Shut down the context; the nodes must have ended."""
        rclpy.try_shutdown(context=self.context)

    def _on_signal(self, _number: int, _frame: FrameType | None) -> None:
        self._end.begin()
