"""A process of ROS 2: one context, and one end, by a signal or by a fault."""

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
"""Longer than all that ends in good order may take together."""
MIDDLEWARE_S = 5
"""Fast DDS may wait for itself for ever where processes that know each other end together (eProsima/Fast-DDS#6193)."""


class Process:
    """Works until a signal comes, or something in it fails.

    Args:
        argv: of the program, with what stands behind ``--ros-args``.

    Raises:
        UsageError: an argument is none of ROS 2.
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
        """End with an error, so that the launcher starts this process again; in any thread."""
        if self._end.fail(error):
            self._end.begin()

    def bound_middleware(self) -> None:
        """Only the middleware has still to end; if it hangs, the process leaves after `MIDDLEWARE_S`."""
        if self.ending:
            leave_within(MIDDLEWARE_S, self._end.exit_code)

    def close(self) -> None:
        """Give the context back; the nodes have ended."""
        rclpy.try_shutdown(context=self.context)

    def _on_signal(self, _number: int, _frame: FrameType | None) -> None:
        self._end.begin()
