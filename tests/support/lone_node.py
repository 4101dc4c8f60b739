"""A transport of the test for one node, which needs no ROS then."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any

from end_effector_hal.control import Answer
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.nodes.interface import Action, Service, Topic
from end_effector_hal.nodes.transport import Frames, UnknownSenders
from end_effector_hal.wires import now_us


class LoneTransport:
    """Keeps what a node publishes; a test calls what it has registered."""

    name = "lone"

    def __init__(self, tool: Description | None = None, without: tuple[Action, ...] = ()) -> None:
        self.log = logging.getLogger("tests.lone_node")
        self.unknown_senders = UnknownSenders(lambda alarm: None, now_us)
        self.published: dict[str, list[Any]] = {}
        self.callbacks: dict[str, Callable[[Any], None]] = {}
        self.ticks: dict[float, Callable[[], None]] = {}
        self.closers: list[Callable[[], None]] = []
        self.goals: dict[str, Callable[[Any], None]] = {}
        self.services: dict[str, Callable[[Any], Answer]] = {}
        self.answers: Callable[[int], Answer] = lambda command: Answer(True)
        self._tool, self._without = tool or load(profile_path()), without

    def description(self) -> Description:
        return self._tool

    def frames(self, description: Description) -> Frames:
        return Frames(description)

    def publisher(self, topic: Topic) -> Callable[[Any], None]:
        return self.published.setdefault(topic.name, []).append

    def subscribe(self, topic: Topic, callback: Callable[[Any], None]) -> None:
        self.callbacks[topic.name] = callback

    def every(self, rate_hz: float, callback: Callable[[], None]) -> None:
        self.ticks[rate_hz] = callback

    def on_start(self, callback: Callable[[], None]) -> None:
        callback()

    def on_close(self, callback: Callable[[], None]) -> None:
        self.closers.insert(0, callback)

    def command_client(self, service: Service) -> Any:
        return self

    def serve(self, service: Service, handler: Callable[[Any], Answer]) -> None:
        self.services[service.name] = handler

    def ask(self, command: int) -> Answer:
        """As the client of another node, which answers what a test says."""
        return self.answers(command)

    def offers(self, action: Action) -> bool:
        return action not in self._without

    def action_server(self, action: Action, on_goal: Callable[[Any], None], *_: Any) -> Any:
        self.goals[action.name] = on_goal
        return self

    def close(self) -> None:
        """As an action server without a goal."""
