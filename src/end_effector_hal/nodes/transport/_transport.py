"""The protocol that a ROS generation implements for the nodes.

Rule 1. An outgoing message is one of `_messages`. The transport converts it to the type in the interface table, field
by field.

Rule 2. An incoming message or request is any object with the fields of its definition.

Rule 3. Publishing never waits for a subscriber. Beyond the queue length of the interface table the oldest message is
dropped; on a latched topic a new subscriber gets the last message at once, and only that one.

Rule 4. A subscriber gets the messages of every node, those of one node in the order in which it sent them. Nothing that
comes by a topic moves a line: commands come by actions and services, and everything else from the tool of the process.

Rule 5. Callbacks come in any thread, also two at a time: a node locks the data that they share. A callback of a topic
returns at once. A service handler may block for as long as its command takes; nothing else waits for it.

Rule 6. An exception of a callback is logged, and ends neither the transport nor the callbacks that follow.

Rule 7. ``log`` never waits for a file, a terminal or a subscriber; it keeps the order of the lines, and all of them
are written before the process ends.

Rule 8. A node ends once: first its periodic callbacks stop, then the ``on_close`` callbacks run while topics are open,
then the topics close, then the ``on_end`` callbacks run. Both run in the reverse order of their registration.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any, Protocol

from end_effector_hal.control import Answer
from end_effector_hal.control.goals import Ending
from end_effector_hal.description import Description
from end_effector_hal.errors import ReportedError
from end_effector_hal.nodes.interface import Action, Parameter, Service, Topic
from end_effector_hal.runtime import Tool

from ._messages import GoalMessage


class Publisher(Protocol):
    """Publishes the messages of one topic (rules 1 and 3)."""

    def __call__(self, message: Any) -> None:
        """Publish a message."""

    def is_read(self) -> bool:
        """Return whether a message reaches anyone: there is a subscriber, or the topic is latched."""


class ClientGoal(Protocol):
    """A goal that a client has sent; objects for the same goal are equal. Each call returns at once.

    Messages to the client are those of `_messages`, converted to the type of the action (rule 1).
    """

    @property
    def request(self) -> Any:
        """The content of the goal (rule 2)."""

    def begin(self) -> None:
        """Report to the client that its goal is being executed."""

    def publish_feedback(self, feedback: Any) -> None:
        """Report the progress of its goal to the client."""

    def end(self, ending: Ending, result: Any) -> None:
        """Report the end of its goal to the client, with the status of the goal and the result of its action."""


class ActionServer(Protocol):
    """The server of one action."""

    def close(self) -> None:
        """Send the results that are not sent yet."""


class ActionClient(Protocol):
    """A client of one action; its callbacks come in any thread."""

    def is_ready(self) -> bool:
        """Return whether the server is available, as far as that is known."""

    def send(
        self,
        goal: GoalMessage,
        on_feedback: Callable[[Any], None],
        on_end: Callable[[Any, bool], None],
    ) -> None:
        """Send a goal.

        Args:
            goal: its content (rule 1).
            on_feedback: called with each feedback.
            on_end: called with the result, and whether the server reports success; a result of None: the server no
                longer has the goal.
        """

    def cancel_all(self) -> None:
        """Cancel every goal of this action, of any client."""


class NodeTransport(Protocol):
    """One node of the graph; see the rules of this module.

    Attributes:
        name: name of the node, without a leading slash.
        log: its logger.
        generation: generation of ROS, 1 or 2.
    """

    name: str
    log: logging.Logger
    generation: int

    def description(self) -> Description:
        """Return the tool that the parameters name; raises DescriptionError."""

    def tool(self) -> Tool:
        """Return the tool of this process, which its nodes share; see `open_tool`."""

    def parameter(self, parameter: Parameter) -> str:
        """Return a parameter of this node."""

    def parameter_once(self, parameter: Parameter) -> str:
        """Return a parameter and remove it, so that the next node of this name does not find it."""

    def publisher(self, topic: Topic) -> Publisher:
        """Open a topic for messages of this node."""

    def subscribe(self, topic: Topic, callback: Callable[[Any], None]) -> None:
        """Call ``callback`` for every message of a topic (rules 2, 4 and 5)."""

    def serve(self, service: Service, handler: Callable[[Any], Answer]) -> None:
        """Answer the calls of a service; the transport makes its response from the answer."""

    def call(self, service: Service) -> Answer | None:
        """Call a service without arguments and return its answer; None: its node cannot be reached."""

    def offers(self, action: Action) -> bool:
        """Return whether this generation has the type of an action; a type that is only not installed is logged."""

    def action_server(
        self,
        action: Action,
        on_goal: Callable[[ClientGoal], None],
        on_cancel: Callable[[ClientGoal], bool],
        result: Callable[[Ending], Any],
    ) -> ActionServer:
        """Serve an action.

        Args:
            action: an action of the interface table.
            on_goal: called with each new goal.
            on_cancel: called when a client cancels a goal; returns whether that can have an effect.
            result: makes the result of a goal that the server ends by itself: too many goals, or an overlong id.
        """

    def action_client(self, action: Action) -> ActionClient:
        """Return a client of an action."""

    def every(self, rate_hz: float, callback: Callable[[], None]) -> None:
        """Call ``callback`` at a rate; calls missed during a pause of the machine are skipped."""

    def on_start(self, callback: Callable[[], None]) -> None:
        """Call ``callback`` when all nodes of this process exist."""

    def on_close(self, callback: Callable[[], None]) -> None:
        """Call ``callback`` at the end, while the node can still publish (rule 8)."""

    def on_end(self, callback: Callable[[], None]) -> None:
        """Call ``callback`` at the very end, after the last message (rule 8)."""

    @property
    def ending(self) -> bool:
        """Whether the end has begun."""

    def fail(self, error: ReportedError) -> None:
        """End the node with an error, so that its launcher restarts it; callable from any thread."""
