"""A transport and a tool of the test for one node, which needs neither ROS nor a HAL then."""

from __future__ import annotations

import logging
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from end_effector_hal.control import Answer, Status
from end_effector_hal.control.goals import Outcome
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.nodes.interface import Action, Parameter, Service, Topic
from end_effector_hal.runtime import Result
from end_effector_hal.sensing import JudgedReadings
from end_effector_hal.vocabulary import Command, EndEffectorState, Evidence
from end_effector_hal.wires import now_us
from end_effector_hal.wires.sensors import SensorHealth


def status(
    state: EndEffectorState = EndEffectorState.STAND_BY, count: int = 1, actuators: int = 3, **fields: Any
) -> Status:
    """A status of a tool that works."""
    given = {
        "at": now_us(),
        "ee": state,
        "command": Command.NONE,
        "actuators": (0,) * actuators,
        "outputs": (False,) * actuators,
        "evidence": (Evidence.GONE,) * actuators,
        "link_up": True,
        "begun": 1,
        "count": count,
    }
    return Status(**{**given, **fields})


class LoneTool:
    """In place of a tool: it says what a test says, at once and in the thread of the test.

    Attributes:
        asked: the commands that it was given.
        answer: its answer to the next ones.
        ends: the end of a goal; None: it does not end in time.
    """

    def __init__(self, description: Description | None = None) -> None:
        self.description = description or load(profile_path())
        self.status = status(actuators=len(self.description.sequence), link_up=False, begun=0, count=0)
        self.alive, self.sensors = True, SensorHealth({}, None)
        self.asked: list[object] = []
        self.answer = Answer(True, count=7)
        self.ends: Result | None = Result(Outcome.SUCCEEDED, EndEffectorState.STAND_BY)
        self._statuses: list[Callable[[Status], None]] = []
        self._readings: list[Callable[[JudgedReadings], None]] = []
        self.keys: list[Callable[[JudgedReadings], object] | None] = []
        self.latest = JudgedReadings(now_us(), {})

    def subscribe(self, listener: Callable[[Status], None], *, name: str = "") -> None:
        self._statuses.append(listener)

    def subscribe_readings(
        self,
        listener: Callable[[JudgedReadings], None],
        *,
        name: str = "",
        key: Callable[[JudgedReadings], object] | None = None,
    ) -> None:
        self._readings.append(listener)
        self.keys.append(key)

    def follow_readings(self) -> Callable[[], JudgedReadings]:
        return lambda: self.latest

    def says(self, status: Status) -> None:
        self.status = status
        for each in self._statuses:
            each(status)

    def reads(self, *sampled: str, **values: int | bool | None) -> None:
        """Give its listeners readings; all of them were sampled unless the names of some are given."""
        known = dict.fromkeys(self.description.channels) | values
        self.latest = JudgedReadings(now_us(), known, sampled or tuple(values))
        for each in self._readings:
            each(self.latest)

    def ending(self, on: str = "sigterm") -> str:
        return "What is held stays held."

    def command(self, name: str, part: str = "") -> Answer:
        self.asked.append((name, part) if part else name)
        return self.answer

    def arm(self) -> Answer:
        return self.command("arm")

    def resume(self) -> Answer:
        return self.command("resume")

    def begin(self, command: Command) -> Any:
        self.asked.append(command)
        return SimpleNamespace(wait=self._wait)

    def set_actuator(self, name: str, active: bool) -> Answer:
        self.asked.append((name, active))
        return self.answer

    set_output = set_actuator

    def stop(self) -> Answer:
        return self.command("stop")

    def reset(self) -> Answer:
        return self.command("reset")

    def _wait(self, timeout_s: float) -> Result:
        if self.ends is None:
            raise TimeoutError(f"not within {timeout_s:g} s")
        return self.ends


class Messages(list[Any]):
    """The messages of one topic; ``read``: whether it has a subscriber."""

    read = True

    def __call__(self, message: Any) -> None:
        self.append(message)

    def is_read(self) -> bool:
        return self.read


class LoneTransport:
    """Keeps what a node publishes; a test calls what it has registered."""

    name = "lone"

    def __init__(self, tool: Description | None = None, without: tuple[Action, ...] = ()) -> None:
        self.log = logging.getLogger("tests.lone_node")
        self.published: dict[str, Messages] = {}
        self.ticks: dict[float, Callable[[], None]] = {}
        self.closers: list[Callable[[], None]] = []
        self.goals: dict[str, Callable[[Any], None]] = {}
        self.services: dict[str, Callable[[Any], Answer]] = {}
        self.hal, self._without = LoneTool(tool), without

    def tool(self) -> LoneTool:
        return self.hal

    def parameter(self, parameter: Parameter) -> str:
        return ""

    def publisher(self, topic: Topic) -> Messages:
        return self.published.setdefault(topic.name, Messages())

    def every(self, rate_hz: float, callback: Callable[[], None]) -> None:
        self.ticks[rate_hz] = callback

    def on_close(self, callback: Callable[[], None]) -> None:
        self.closers.insert(0, callback)

    def serve(self, service: Service, handler: Callable[[Any], Answer]) -> None:
        self.services[service.name] = handler

    def offers(self, action: Action) -> bool:
        return action not in self._without

    def action_server(self, action: Action, on_goal: Callable[[Any], None], *_: Any) -> Any:
        self.goals[action.name] = on_goal
        return self

    def close(self) -> None:
        """As an action server without a goal."""
