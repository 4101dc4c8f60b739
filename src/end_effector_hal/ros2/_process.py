"""A process of ROS 2 with one context and one end, and its nodes, which start and end together and share one tool."""

from __future__ import annotations

import logging
import os
import signal
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from types import FrameType

import rclpy
from rclpy.action import ActionClient, ActionServer
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from end_effector_hal.description import Description
from end_effector_hal.errors import ReportedError, RosError, UsageError
from end_effector_hal.nodes.interface import HAL_MAIN
from end_effector_hal.nodes.process import ProcessEnd, Starters, Ticks, leave_within
from end_effector_hal.nodes.start import open_tool
from end_effector_hal.nodes.transport import NodeTransport
from end_effector_hal.runtime import Tool

from ._transports import without_shared_memory

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
        without_shared_memory(os.environ)
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


_log = logging.getLogger("end_effector_hal.ros2")
LAST_MESSAGES_S = 0.05
"""Time for the last messages to leave the queues, s."""
NODES_END_S = 5.0
WORKERS = 16
"""Maximum number of service calls that may block at the same time."""


class NodeGroup:
    """Runs nodes until they are closed, or one of them fails, which ends the process.

    Args:
        process: the process that they run in.
        names: the nodes that will run here; HALMain, whose parameters say how the tool is run, is the first.
        arguments: arguments of ROS that replace those of the process.
        parameters: values for parameters that the arguments do not set.
        description: the tool, which overrides their parameters; None: the parameters name it.
    """

    def __init__(
        self,
        process: Process,
        names: Sequence[str],
        arguments: Sequence[str] | None = None,
        parameters: Mapping[str, str] | None = None,
        description: Description | None = None,
    ) -> None:
        self._process, self._arguments = process, arguments
        self.parameters, self.description = dict(parameters or {}), description
        self.executor = SingleThreadedExecutor(context=process.context)
        self.workers = ThreadPoolExecutor(WORKERS, thread_name_prefix="service")
        together = threading.Barrier(WORKERS, timeout=NODES_END_S)
        for _ in range(WORKERS):  # all threads are started now: a call needs no new one
            self.workers.submit(together.wait)
        self._hosts = HAL_MAIN in names
        self._tool: Tool | None = None
        self._closing = self._closed = False
        self._nodes: list[Node] = []
        self._ticks = Ticks()
        self.every = self._ticks.add
        self._starters = Starters()
        self.on_start, self.start = self._starters.add, self._starters.start
        self._closers: list[Callable[[], None]] = []
        self._enders: list[Callable[[], None]] = []
        self._thread = threading.Thread(target=self._spin, name="ros2", daemon=True)

    def tool(self, node: NodeTransport) -> Tool:
        """Return the tool that the nodes share; the first ``node`` that calls this opens it."""
        if self._tool is None:
            self._tool = open_tool(node, hosts=self._hosts)
        return self._tool

    def node(self, name: str) -> Node:
        """Return a new node of rclpy in this group."""
        own = (
            {} if self._arguments is None else {"cli_args": [*self._arguments], "use_global_arguments": False}
        )
        try:
            node = Node(name, context=self._process.context, **own)
        except Exception as error:  # noqa: BLE001 rclpy has a class for each part of it
            raise UsageError(f"The node {name} cannot be made: {error}") from None
        self.add(node, name)
        return node

    def add(self, node: Node, name: str) -> None:
        """Run a node in this group; raises UsageError if its name is taken in the group, or the group has ended."""
        if self._closing:
            node.destroy_node()
            raise UsageError(f"{name} is not started: the process ends.")
        taken = any(each.get_name() == node.get_name() for each in self._nodes)
        self._nodes.append(node)
        if taken:
            what = f"Two nodes of this process would be called {node.get_name()}."
            raise UsageError(what, todo=f"Name the one that is meant: -r {name}:__node:=NAME.")
        self.executor.add_node(node)
        if not self._thread.is_alive():
            self._thread.start()

    def on_close(self, callback: Callable[[], None]) -> None:
        """Call ``callback`` at the end, while topics are open."""
        self._closers.insert(0, callback)

    def on_end(self, callback: Callable[[], None]) -> None:
        """Call ``callback`` at the very end, after the last message."""
        self._enders.insert(0, callback)

    @property
    def ending(self) -> bool:
        """Whether the end has begun."""
        return self._closing or self._process.ending

    def fail(self, error: ReportedError) -> None:
        """End the process with an error, so that its launcher restarts it; callable from any thread."""
        self._process.fail(error)

    def close(self) -> None:
        """End all nodes: first call `on_close` callbacks, then end the executor, call `on_end` callbacks, close
        topics.
        """
        if self._closed:
            return
        self._closing = self._closed = True
        self._ticks.close()
        for callback in self._closers:
            _guarded(callback)
        time.sleep(LAST_MESSAGES_S)
        # its thread is gone before a node is destroyed: rclpy would end the process
        self.executor.shutdown(NODES_END_S)
        if self._thread.is_alive():
            self._thread.join(NODES_END_S)
        self.workers.shutdown(wait=False, cancel_futures=True)
        for callback in self._enders:
            _guarded(callback)
        if self._thread.is_alive():
            _log.error("a callback does not return; its nodes are left behind")
            return
        self._process.bound_middleware()
        for node in self._nodes:
            _destroy(node)

    def _spin(self) -> None:
        try:
            self.executor.spin()
        except ExternalShutdownException:
            pass
        except Exception as error:  # noqa: BLE001 it must not end without a word
            if not self.ending:
                _log.exception("the executor of ROS 2 has ended")
                self.fail(RosError(f"The executor of ROS 2 has ended: {error}."))


def _destroy(node: Node) -> None:
    """Destroy a node with its actions, which rclpy omits: their servers would exist until the garbage is collected."""
    for each in list(node.waitables):
        if isinstance(each, ActionServer | ActionClient):
            each.destroy()
    node.destroy_node()


def _guarded(callback: Callable[[], None]) -> None:
    try:
        callback()
    except Exception:  # noqa: BLE001 the others end all the same
        _log.exception("the end of a node failed")
