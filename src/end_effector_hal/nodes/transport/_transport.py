"""What a node needs of a ROS generation.

Rule 1. A message that goes out is one of `_messages`. The transport makes the type of the table from it, field by
field. Nobody changes a message that was published: the nodes of this process may get it as it is.

Rule 2. A message or a request that comes in is any object with the fields of its definition.

Rule 3. Publishing never waits for a subscriber. Beyond the queue of the table the oldest message is dropped; of a
latched topic a new subscriber gets the last message at once, and only that one.

Rule 4. A subscriber gets the messages of the nodes that the table names, in the order in which each of them sent
them. The transport drops all others and counts them in ``unknown_senders``.

Rule 5. Callbacks come in any thread, also two at a time: a node locks what they share. A callback of a topic returns
at once. A service handler may block for as long as its command takes; nothing else waits for it.

Rule 6. What a callback raises is logged, and ends neither the transport nor the callbacks that follow.

Rule 7. ``log`` never waits for a file, a terminal or a subscriber; it keeps the order of the lines, and all of them
are written before the process ends.

Rule 8. A node ends once: first its periodic callbacks stop, then ``on_close`` is called, while topics are open, then
the topics close, then ``on_end`` is called. Both in the reverse order of their registration.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from enum import IntEnum
from typing import Any, Protocol

from end_effector_hal.control import Answer
from end_effector_hal.control.goals import Ending
from end_effector_hal.description import Description
from end_effector_hal.errors import ReportedError
from end_effector_hal.nodes.interface import Action, Parameter, Service, Topic

from ._frames import Frames
from ._unknown_senders import UnknownSenders


class CylinderPlace(IntEnum):
    """Where a cylinder stands (``CylinderPosition``)."""

    UNKNOWN = 0
    RETRACTED = 1
    BETWEEN = 2
    EXTENDED = 3


class ChangerPlace(IntEnum):
    """Where the tool changer stands (``ToolChangerPosition``)."""

    UNKNOWN = 0
    LOCKED = 1
    UNLOCKED = 2
    BETWEEN = 3
    CONTRADICTORY = 4


class CommandClient(Protocol):
    """Gives commands to the program of another node."""

    def ask(self, command: int) -> Answer:
        """Give a command of Table II and wait for the answer, at most 4 s; a node that is silent is refused."""

    def send(self, command: int, on_answer: Callable[[Answer], None]) -> None:
        """Give a command and return at once; the answer comes in another thread, or never."""

    def give_up(self) -> None:
        """The answer has not come in time: one that comes later does not count."""


class ClientGoal(Protocol):
    """A goal that a client has sent; two are equal when they stand for the same one. Each call returns at once.

    Messages to the client are those of `_messages`, made to the type of the action (rule 1).
    """

    @property
    def request(self) -> Any:
        """What it asks for (rule 2)."""

    def begin(self) -> None:
        """Tell the client that its goal is being executed."""

    def publish_feedback(self, feedback: Any) -> None:
        """Tell the client how far its goal is."""

    def end(self, ending: Ending, result: Any) -> None:
        """Tell the client how its goal ended: by the status of the goal, and by the result of its action."""


class ActionServer(Protocol):
    """The server of one action."""

    def close(self) -> None:
        """Send the results that are not sent yet."""


class ActionClient(Protocol):
    """A client of one action. Its callbacks come in any thread."""

    def is_ready(self) -> bool:
        """Whether the server is there, as far as that is known."""

    def send(
        self,
        on_feedback: Callable[[Any], None],
        on_end: Callable[[Any, bool], None],
    ) -> None:
        """Send a goal.

        Args:
            on_feedback: gets each feedback.
            on_end: gets the result, and whether the server calls it a success; None: the server does not know the
                goal any more.
        """

    def cancel_all(self) -> None:
        """Cancel every goal of this action, of any client."""


class NodeTransport(Protocol):
    """One node of the graph; see the rules of this module.

    Attributes:
        name: of the node, without a leading slash.
        log: its logger.
        generation: of ROS, 1 or 2.
        unknown_senders: messages and calls that were dropped.
    """

    name: str
    log: logging.Logger
    generation: int
    unknown_senders: UnknownSenders

    def description(self) -> Description:
        """The tool that the parameters name; raises DescriptionError."""

    def frames(self, description: Description) -> Frames:
        """What the nodes of this process that work with this tool share of its frames."""

    def parameter(self, parameter: Parameter, default: str = "") -> str:
        """A parameter of this node."""

    def parameter_once(self, parameter: Parameter) -> str:
        """A parameter that the next node of this name does not find."""

    def publisher(self, topic: Topic) -> Callable[[Any], None]:
        """A function that publishes a message on a topic (rules 1 and 3)."""

    def subscribe(self, topic: Topic, callback: Callable[[Any], None]) -> None:
        """Call ``callback`` for every message of a topic (rules 2, 4 and 5)."""

    def serve(self, service: Service, handler: Callable[[Any], Answer]) -> None:
        """Answer the calls of a service; the transport makes its response from the answer."""

    def refuse_unknown_caller(self, service: Service, request: Any) -> str:
        """Why a call of an internal service is refused; empty: it comes from a node that the table names."""

    def call(self, service: Service) -> Answer | None:
        """Call a service without arguments; None: its node cannot be reached."""

    def command_client(self, service: Service) -> CommandClient:
        """A client that gives commands to another node."""

    def offers(self, action: Action) -> bool:
        """Whether this generation has the type of an action; of one that is only missing here the log says so."""

    def action_server(
        self,
        action: Action,
        on_goal: Callable[[ClientGoal], None],
        on_cancel: Callable[[ClientGoal], bool],
        result: Callable[[Ending], Any],
    ) -> ActionServer:
        """Serve an action.

        Args:
            action: of the table.
            on_goal: called with each goal that comes.
            on_cancel: called when a client cancels a goal; returns whether that can change anything.
            result: makes the result of a goal that the server ends by itself: too many, or an id without bounds.
        """

    def action_client(self, action: Action) -> ActionClient:
        """A client of an action."""

    def every(self, rate_hz: float, callback: Callable[[], None]) -> None:
        """Call ``callback`` at a rate; after a pause of the machine ticks are left out, not made up for."""

    def on_start(self, callback: Callable[[], None], *, last: bool = False) -> None:
        """Call ``callback`` when all nodes of this process are there; ``last``: behind those of the others."""

    def on_close(self, callback: Callable[[], None]) -> None:
        """Call ``callback`` at the end, while the node can still publish (rule 8)."""

    def on_end(self, callback: Callable[[], None]) -> None:
        """Call ``callback`` at the very end, when no message comes any more (rule 8)."""

    @property
    def ending(self) -> bool:
        """Whether the end has begun."""

    def fail(self, error: ReportedError) -> None:
        """End the node with an error, so that its launcher starts it again; in any thread."""
