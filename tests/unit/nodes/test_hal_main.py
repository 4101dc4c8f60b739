"""HALMain on a transport of the test: it needs no ROS."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import replace
from typing import Any, cast

import pytest

from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.nodes.hal_main import HalMainNode
from end_effector_hal.nodes.interface import END_EFFECTOR_STATE, GRIP_STATE, STATE_HZ, Action, Service, Topic
from end_effector_hal.nodes.transport import StatusMessage, UnknownSenders
from end_effector_hal.vocabulary import Command, EndEffectorState
from end_effector_hal.wires import now_us


class Transport:
    """Keeps what a node publishes; a test calls what it has registered."""

    name = "HALMain"

    def __init__(self) -> None:
        self.log = logging.getLogger("tests.hal_main")
        self.unknown_senders = UnknownSenders(lambda alarm: None, now_us)
        self.published: dict[str, list[Any]] = {}
        self.callbacks: dict[str, Callable[[Any], None]] = {}
        self.ticks: dict[float, Callable[[], None]] = {}
        self.closers: list[Callable[[], None]] = []

    def description(self) -> Description:
        return load(profile_path())

    def publisher(self, topic: Topic) -> Callable[[Any], None]:
        return self.published.setdefault(topic.name, []).append

    def subscribe(self, topic: Topic, callback: Callable[[Any], None]) -> None:
        self.callbacks[topic.name] = callback

    def every(self, rate_hz: float, callback: Callable[[], None]) -> None:
        self.ticks[rate_hz] = callback

    def on_close(self, callback: Callable[[], None]) -> None:
        self.closers.insert(0, callback)

    def command_client(self, service: Service) -> Any:
        return self

    def offers(self, action: Action) -> bool:
        return True

    def action_server(self, action: Action, *_: Any) -> Any:
        return self

    def close(self) -> None:
        """As an action server without a goal."""

    @property
    def states(self) -> list[EndEffectorState]:
        return [EndEffectorState(each.state) for each in self.published[END_EFFECTOR_STATE.name]]


@pytest.fixture
def transport() -> Transport:
    transport = Transport()
    HalMainNode(cast("Any", transport))
    return transport


def status(count: int, state: EndEffectorState) -> StatusMessage:
    now = now_us()
    return StatusMessage(
        since_us=1,
        count=count,
        at_us=now,
        state=state,
        actuators=[0] * 3,
        outputs=[False] * 3,
        evidence=[1] * 3,
    )


def test_every_status_is_one_state_and_a_repeated_one_is_none(transport: Transport) -> None:
    grip = transport.callbacks[GRIP_STATE.name]
    first = status(1, EndEffectorState.STAND_BY)
    grip(first)
    grip(replace(first))
    grip(status(2, EndEffectorState.GRIPPING))
    assert transport.states == [EndEffectorState.STAND_BY, EndEffectorState.GRIPPING]
    states = transport.published[END_EFFECTOR_STATE.name]
    first_count, second_count = (each.count for each in states)
    assert second_count == first_count + 1
    assert [each.state_name for each in states] == ["STAND_BY", "GRIPPING"]
    assert len({each.since_us for each in states}) == 1


def test_beside_each_integer_stands_its_name(transport: Transport) -> None:
    message = status(1, EndEffectorState.GRIPPED)
    message.actuators, message.evidence, message.cause, message.tool_changer = [2, 1, 0], [3, 2, 0], 1, 1
    transport.callbacks[GRIP_STATE.name](message)
    (state,) = transport.published[END_EFFECTOR_STATE.name]
    assert (state.state_name, state.command_name, state.cause_name) == ("GRIPPED", "NONE", "TIMED_OUT")
    assert state.actuator_states == ["ON", "PENDING_EXTEND", "OFF"]
    assert state.evidence_names == ["CONFIRMED", "PARTIAL", "UNKNOWN"]
    assert (state.tool_position_name, state.tool_stand_name) == ("UNKNOWN", "UNKNOWN")
    assert (state.tool, state.margin_units) == ("verdin_gripper", ["Pa"] * 3)


def test_off_is_the_last_state_whatever_comes_later(
    transport: Transport, caplog: pytest.LogCaptureFixture
) -> None:
    grip = transport.callbacks[GRIP_STATE.name]
    grip(status(1, EndEffectorState.STAND_BY))
    for close in transport.closers:
        close()
    with caplog.at_level(logging.INFO):
        grip(status(2, EndEffectorState.GRIPPED))
        transport.ticks[STATE_HZ]()
    assert transport.states == [EndEffectorState.STAND_BY, EndEffectorState.OFF]
    last = transport.published[END_EFFECTOR_STATE.name][-1]
    assert (last.command, last.lift_allowed, last.secure) == (Command.NONE, False, False)
    assert caplog.records == []
