"""A node of ROS 1: its start, communication and end with rospy."""

from __future__ import annotations

import logging
import signal
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from types import FrameType, TracebackType
from typing import Any, Self

import rospy

from end_effector_hal.control import Answer
from end_effector_hal.control.goals import Ending
from end_effector_hal.description import Description
from end_effector_hal.errors import ReportedError, RosError, UsageError
from end_effector_hal.nodes.interface import (
    DESCRIPTION,
    HAL_MAIN,
    Action,
    Parameter,
    Service,
    Topic,
    load_for_nodes,
)
from end_effector_hal.nodes.process import ProcessEnd, Starters, Ticks, node_log
from end_effector_hal.nodes.start import open_tool
from end_effector_hal.nodes.transport import ActionClient, ActionServer, ClientGoal, answer_of
from end_effector_hal.runtime import Tool

from ._messages import TopicPublisher, message_class, response_maker, service_class
from ._name_taken import node_name, private_parameter, refuse_taken_name, tool_named
from .master import MasterWatch

_LEVELS = (
    (logging.ERROR, rospy.logerr),
    (logging.WARNING, rospy.logwarn),
    (logging.INFO, rospy.loginfo),
    (logging.DEBUG, rospy.logdebug),
)


def write_line(level: int, text: str) -> None:
    """Write a text at a level of `logging`, with the name of this node, which the console does not show."""
    log = next((log for least, log in _LEVELS if level >= least), rospy.logdebug)
    log("%s", f"{rospy.get_name()}: {text}")


LAST_MESSAGES_S = 0.05
"""Time for the last messages to leave the queues, s."""
LONGEST_END_S = 5.0


class RosNode:
    """The transport of one node. Callbacks of topics and services come in rospy's threads, one per connection.

    Raises:
        RosError: there is no master, or a node of this name runs already.
        UsageError: the node needs a tool and none is named, or an argument is invalid for a node.
    """

    generation = 1

    def __init__(self, name: str, argv: Sequence[str]) -> None:
        self._end = ProcessEnd(LONGEST_END_S)
        self._watch = MasterWatch(lambda why: self.fail(RosError(why)))
        full = node_name(name)
        needs_tool = name in DESCRIPTION.nodes
        self._tool = tool_named(argv, private_parameter(full)) if needs_tool else None
        refuse_taken_name(full, str(self._tool or ""))
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self._on_signal)
        try:
            # rospy's handler closes the node within what it interrupts, which may hold a lock that the close needs
            rospy.init_node(name, argv=list(argv), disable_signals=True)
        except rospy.ROSInitException as error:
            raise UsageError(f"{error}.", todo="Private parameters are given as _name:=value.") from None
        self.name = rospy.get_name().lstrip("/")
        self.log, self._log_handler = node_log(name, write_line)
        self._hosts = name == HAL_MAIN
        self._closing = False
        self._closers: list[Callable[[], None]] = []
        self._at_end = ExitStack()
        self._ticks = Ticks()
        self._starters = Starters()
        self.on_start = self._starters.add
        rospy.on_shutdown(self._close)
        rospy.core.add_shutdown_hook(lambda reason: self._end.begin())

    def description(self) -> Description:
        """Return the tool that ``~description`` or ``~profile`` names; raises DescriptionError."""
        assert self._tool is not None, "only nodes of the table have a description"
        return load_for_nodes(self._tool)

    def tool(self) -> Tool:
        """Return the tool, which HALMain runs; every other node talks to it over its socket. Call it once."""
        return open_tool(self, hosts=self._hosts)

    def parameter(self, parameter: Parameter) -> str:
        """Return a private parameter."""
        return str(rospy.get_param("~" + parameter.name, ""))

    def parameter_once(self, parameter: Parameter) -> str:
        """Return a private parameter, and remove it from the parameter server."""
        if text := self.parameter(parameter):
            rospy.delete_param(f"~{parameter.name}")
        return text

    def publisher(self, topic: Topic) -> TopicPublisher:
        """Open a topic for messages of this node."""
        return TopicPublisher(topic, lambda: self._closing)

    def subscribe(self, topic: Topic, callback: Callable[[Any], None]) -> None:
        """Call ``callback`` for every message of a topic."""
        kind = message_class(topic.type)
        rospy.Subscriber(topic.name, kind, callback, queue_size=topic.queue, tcp_nodelay=True)

    def serve(self, service: Service, handler: Callable[[Any], Answer]) -> None:
        """Answer the calls of a service."""
        kind = service_class(service.type)
        respond = response_maker(kind)
        rospy.Service(service.name, kind, lambda request: respond(handler(request)))

    def call(self, service: Service) -> Answer | None:
        """Call a service without arguments and return its answer; None: its node cannot be reached."""
        try:
            return answer_of(rospy.ServiceProxy(service.name, service_class(service.type))())
        except rospy.ServiceException:
            return None

    def offers(self, action: Action) -> bool:
        """Return whether the interface table offers an action in ROS 1."""
        return self.generation in action.generations

    def action_server(
        self,
        action: Action,
        on_goal: Callable[[ClientGoal], None],
        on_cancel: Callable[[ClientGoal], bool],
        result: Callable[[Ending], Any],
    ) -> ActionServer:
        """Serve an action."""
        from ._actions import STATUS_HZ, GoalServer  # only nodes with actions load actionlib
        from ._later import Later

        server = GoalServer(action, on_goal, on_cancel, result, Later(self.log))
        server.start()
        self.every(STATUS_HZ, server.publish_status)
        return server

    def action_client(self, action: Action) -> ActionClient:
        """Return a client of an action."""
        from ._actions import GoalSender

        return GoalSender(action)

    def every(self, rate_hz: float, callback: Callable[[], None]) -> None:
        """Call ``callback`` at a rate, in the thread of the ticks of this process."""
        self._ticks.add(rate_hz, callback, self.log)

    def on_close(self, callback: Callable[[], None]) -> None:
        """Call ``callback`` at the end, while the node can still publish; the last registered one is called first."""
        self._closers.insert(0, callback)

    def on_end(self, callback: Callable[[], None]) -> None:
        """Call ``callback`` when the context manager of this node exits; the last registered one is called first."""
        self._at_end.callback(callback)

    @property
    def ending(self) -> bool:
        """Whether the end has begun."""
        return self._end.begun or bool(rospy.is_shutdown())

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._at_end.close()

    def end(self) -> None:
        """End the node because its work is done or a signal came; must be called in the main thread."""
        self._end.bound()
        rospy.signal_shutdown("quit")

    def spin(self) -> int:
        """Work until the end, and return the exit code; raises the error that :meth:`fail` got."""
        self._starters.start()
        try:
            return self._end.wait()
        finally:
            self.end()

    def fail(self, error: ReportedError) -> None:
        """End the node with an error, so that roslaunch restarts it; callable from any thread."""
        if self._end.fail(error):
            rospy.signal_shutdown(str(error))

    def _on_signal(self, _number: int, _frame: FrameType | None) -> None:
        self._end.begin()

    def _close(self) -> None:
        self._closing = True
        self._watch.close()
        self._ticks.close()
        for callback in self._closers:
            callback()
        self._log_handler.end()
        time.sleep(LAST_MESSAGES_S)
