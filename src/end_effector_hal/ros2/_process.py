"""A process with one or several nodes: one context, one executor in a thread of its own, one end."""

from __future__ import annotations

import logging
import os
import signal
import threading
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from types import FrameType

import rclpy
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from end_effector_hal.errors import ReportedError, RosError, UsageError
from end_effector_hal.nodes.process import Ticker
from end_effector_hal.wires import be_steady

from .connections import LocalBus

LAST_MESSAGES_S = 0.05
"""For the last messages to leave the queues."""
LONGEST_END_S = 5.0
WORKERS = 16
"""Calls of services that may block at once."""


class Process:
    """Runs nodes until a signal comes, or one of them fails.

    Args:
        names: of the nodes that will run here.
        argv: of the program, with what stands behind ``--ros-args``.

    Raises:
        UsageError: an argument is none of ROS 2.
        RosError: ROS 2 cannot be started.
    """

    def __init__(self, names: Sequence[str], argv: Sequence[str]) -> None:
        self.context = Context()
        try:
            rclpy.init(args=list(argv), context=self.context, signal_handler_options=SignalHandlerOptions.NO)
        except Exception as error:  # noqa: BLE001 rclpy has a class for each part of it
            if "argument" in str(error).lower():
                why = str(error).partition(", at ")[0]
                raise UsageError(why, todo="Such as: --ros-args -p profile:=verdin_gripper") from None
            raise RosError(f"ROS 2 cannot be started: {error}.") from None
        self.executor = SingleThreadedExecutor(context=self.context)
        self.workers = ThreadPoolExecutor(WORKERS, thread_name_prefix="service")
        self.bus = LocalBus(frozenset(names), logging.getLogger("end_effector_hal.ros2"))
        self.closing = False
        self._failed: ReportedError | None = None
        self._ended = threading.Event()
        self._nodes: list[Node] = []
        self._tickers: list[Ticker] = []
        self._closers: list[Callable[[], None]] = []
        self._enders: list[Callable[[], None]] = []
        self._thread = threading.Thread(target=self._spin, name="ros2", daemon=True)
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._on_signal)

    def node(self, name: str) -> Node:
        """A node of rclpy in this process."""
        node = Node(name, context=self.context)
        taken = any(each.get_name() == node.get_name() for each in self._nodes)
        self._nodes.append(node)
        if taken:
            what = f"Two nodes of this process would be called {node.get_name()}."
            raise UsageError(what, todo=f"Name the one that is meant: -r {name}:__node:=NAME.")
        self.executor.add_node(node)
        if not self._thread.is_alive():
            self._thread.start()
        return node

    def every(self, rate_hz: float, callback: Callable[[], None], log: logging.Logger) -> None:
        """Call back at a rate, in a thread of its own."""
        self._tickers.append(Ticker(1 / rate_hz, callback, log))

    def on_close(self, callback: Callable[[], None]) -> None:
        """Call ``callback`` at the end, while topics are open."""
        self._closers.insert(0, callback)

    def on_end(self, callback: Callable[[], None]) -> None:
        """Call ``callback`` at the very end."""
        self._enders.insert(0, callback)

    @property
    def ending(self) -> bool:
        """Whether the end has begun."""
        return self.closing or self._ended.is_set()

    def end(self) -> None:
        """End, for the work is done."""
        self._ended.set()

    def fail(self, error: ReportedError) -> None:
        """End with an error, so that the launcher starts this process again; in any thread."""
        if self._failed is None:
            self._failed = error
            threading.Thread(target=_leave_by_force, args=(error,), daemon=True).start()
            self._ended.set()

    def wait(self) -> int:
        """Wait for the end; the exit code. Raises what :meth:`fail` was given."""
        be_steady()
        self._ended.wait()
        if self._failed is not None:
            raise self._failed
        return 0

    def close(self) -> None:
        """End all nodes: callbacks while the topics are open, then the topics, then the last callbacks."""
        self.closing = True
        for ticker in self._tickers:
            ticker.close()
        for callback in self._closers:
            _guarded(callback)
        time.sleep(LAST_MESSAGES_S)
        # its thread is gone before a node is destroyed: rclpy would end the process
        self.executor.shutdown(LONGEST_END_S)
        if self._thread.is_alive():
            self._thread.join(LONGEST_END_S)
        self.workers.shutdown(wait=False, cancel_futures=True)
        for node in self._nodes:
            node.destroy_node()
        for callback in self._enders:
            _guarded(callback)
        rclpy.try_shutdown(context=self.context)

    def _spin(self) -> None:
        try:
            self.executor.spin()
        except ExternalShutdownException:
            pass
        except Exception as error:
            if not self.ending:
                logging.getLogger("end_effector_hal.ros2").exception("the executor of ROS 2 has ended")
                self.fail(RosError(f"The executor of ROS 2 has ended: {error}."))

    def _on_signal(self, _number: int, _frame: FrameType | None) -> None:
        self._ended.set()


def _guarded(callback: Callable[[], None]) -> None:
    try:
        callback()
    except Exception:
        logging.getLogger("end_effector_hal.ros2").exception("the end of a node failed")


def _leave_by_force(error: ReportedError) -> None:
    time.sleep(LONGEST_END_S)
    os._exit(error.exit_code)
