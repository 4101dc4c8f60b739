"""A node of ROS 2: its start, communication and end with rclpy."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.task import Future

from end_effector_hal.control import Answer
from end_effector_hal.control.goals import Ending
from end_effector_hal.description import Description, tool_path
from end_effector_hal.nodes.interface import (
    DESCRIPTION,
    PARAMETERS,
    PROFILE,
    Action,
    Parameter,
    Service,
    Topic,
    load_for_nodes,
)
from end_effector_hal.nodes.process import node_log
from end_effector_hal.nodes.transport import ActionClient, ActionServer, ClientGoal, answer_of
from end_effector_hal.runtime import Tool

from ._actions import RclpyActionClient, RclpyActionServer
from ._messages import (
    RclpyPublisher,
    has_action_class,
    message_class,
    reader_quality,
    response_maker,
    service_class,
)
from ._process import NodeGroup


def writer_of(node: Node) -> Callable[[int, str], None]:
    """Return a function that writes a text at a level of `logging`."""
    # each place of the code may log at one level only
    logger = node.get_logger()

    def write(level: int, text: str) -> None:
        if level >= logging.ERROR:
            logger.error(text)
        elif level >= logging.WARNING:
            logger.warning(text)
        else:
            logger.info(text)

    return write


def declared(node: Node, parameter: Parameter, default: str = "") -> str:
    """Declare a parameter, and return its value."""
    descriptor = ParameterDescriptor(description=parameter.about, read_only=True, dynamic_typing=True)
    value = node.declare_parameter(parameter.name, default, descriptor).value
    return "" if value is None else str(value)


HOW = "--ros-args -p description:=FILE or -p profile:=NAME"
CALL_S = 5.0


class RclpyNode:
    """The transport of one node.

    Callbacks of topics run in the executor's thread, those of services in threads of their own.

    Args:
        name: name of the node in the interface table.
        group: the group that it runs in.
    """

    generation = 2

    def __init__(self, name: str, group: NodeGroup) -> None:
        self._group, self._node = group, group.node(name)
        self.name = self._node.get_name()
        self.log, self._log_handler = node_log(name, writer_of(self._node))
        self._topics, self._calls = MutuallyExclusiveCallbackGroup(), ReentrantCallbackGroup()
        self._parameters = {
            each.name: declared(self._node, each, group.parameters.get(each.name, ""))
            for each in PARAMETERS
            if name in each.nodes
        }
        self.on_start, self.on_close = group.on_start, group.on_close
        self.on_end, self.fail = group.on_end, group.fail
        self.on_close(self._log_handler.end)

    def description(self) -> Description:
        """Return the tool that the parameter ``description`` or ``profile`` names; raises DescriptionError."""
        if self._group.description is not None:
            return self._group.description
        given = [self._parameters.get(each.name, "") for each in (DESCRIPTION, PROFILE)]
        return load_for_nodes(tool_path(*given, how=HOW))

    def tool(self) -> Tool:
        """Return the tool that the nodes of this group share."""
        return self._group.tool(self)

    def parameter(self, parameter: Parameter) -> str:
        """Return a parameter."""
        return self._parameters.get(parameter.name, "")

    def parameter_once(self, parameter: Parameter) -> str:
        """Return a parameter; in ROS 2 it ends with its node, and need not be removed."""
        return self.parameter(parameter)

    def publisher(self, topic: Topic) -> RclpyPublisher:
        """Open a topic for messages of this node."""
        return RclpyPublisher(self._node, topic)

    def subscribe(self, topic: Topic, callback: Callable[[Any], None]) -> None:
        """Call ``callback`` for every message of a topic."""

        def guarded(message: Any) -> None:
            try:
                callback(message)
            except Exception:
                self.log.exception("a callback of %s failed", topic.name)

        self._node.create_subscription(
            message_class(topic.type),
            topic.name,
            guarded,
            reader_quality(topic),
            callback_group=self._topics,
        )

    def serve(self, service: Service, handler: Callable[[Any], Answer]) -> None:
        """Answer the calls of a service."""
        fill = response_maker(service_class(service.type))

        async def answer(request: Any, response: Any) -> Any:
            answered: Future = Future()

            def work() -> None:
                try:
                    reply = handler(request)
                except Exception:
                    self.log.exception("a call of %s failed", service.name)
                    reply = Answer(False, "The call failed because of a fault in the program; see its log.")
                self._group.executor.create_task(lambda: answered.set_result(reply))

            self._group.workers.submit(work)
            return fill(await answered, response)

        self._node.create_service(
            service_class(service.type), service.name, answer, callback_group=self._calls
        )

    def call(self, service: Service) -> Answer | None:
        """Call a service without arguments and return its answer; None: its node cannot be reached."""
        kind = service_class(service.type)
        client = self._node.create_client(kind, service.name, callback_group=self._calls)
        try:
            if not client.wait_for_service(timeout_sec=CALL_S):
                return None
            future = client.call_async(kind.Request())
            answered = _done(future)
            return answer_of(future.result()) if answered.wait(CALL_S) else None
        finally:
            self._node.destroy_client(client)

    def offers(self, action: Action) -> bool:
        """Return whether the type of an action is installed; a missing optional type is logged."""
        if self.generation not in action.generations:
            return False
        if not action.optional or has_action_class(action.type):
            return True
        self.log.info("%s is not offered: the type %s is not installed", action.name, action.type)
        return False

    def action_server(
        self,
        action: Action,
        on_goal: Callable[[ClientGoal], None],
        on_cancel: Callable[[ClientGoal], bool],
        result: Callable[[Ending], Any],
    ) -> ActionServer:
        """Serve an action."""
        return RclpyActionServer(self._node, action, on_goal, on_cancel, result, self.log)

    def action_client(self, action: Action) -> ActionClient:
        """Return a client of an action."""
        return RclpyActionClient(self._node, action)

    def every(self, rate_hz: float, callback: Callable[[], None]) -> None:
        """Call ``callback`` at a rate, in the thread of the ticks of this process."""
        self._group.every(rate_hz, callback, self.log)

    @property
    def ending(self) -> bool:
        """Whether the end has begun."""
        return self._group.ending


def _done(future: Future) -> threading.Event:
    event = threading.Event()
    future.add_done_callback(lambda _future: event.set())
    return event
