"""HALMain on a transport of the test: it needs no ROS."""

from __future__ import annotations

import logging
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import pytest

from end_effector_hal.control import EventKind
from end_effector_hal.control.goals import Outcome
from end_effector_hal.nodes.hal_main import HalMainNode
from end_effector_hal.nodes.interface import (
    COMMAND_ACTIONS,
    END_EFFECTOR_STATE,
    GRIP_STATE,
    GRIPPER_COMMAND,
    PARALLEL_GRIPPER_COMMAND,
    STATE_HZ,
)
from end_effector_hal.nodes.transport import EventMessage, StatusMessage
from end_effector_hal.vocabulary import ChangerState, Command, EndEffectorState
from end_effector_hal.wires import now_us
from tests.support.lone_node import LoneTransport


def names_of_states(transport: LoneTransport) -> list[EndEffectorState]:
    return [EndEffectorState(each.state) for each in transport.published[END_EFFECTOR_STATE.name]]


@pytest.fixture
def transport() -> LoneTransport:
    transport = LoneTransport()
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


def test_every_status_is_one_state_and_a_repeated_one_is_none(transport: LoneTransport) -> None:
    grip = transport.callbacks[GRIP_STATE.name]
    first = status(1, EndEffectorState.STAND_BY)
    grip(first)
    grip(replace(first))
    grip(status(2, EndEffectorState.GRIPPING))
    assert names_of_states(transport) == [EndEffectorState.STAND_BY, EndEffectorState.GRIPPING]
    states = transport.published[END_EFFECTOR_STATE.name]
    first_count, second_count = (each.count for each in states)
    assert second_count == first_count + 1
    assert [each.state_name for each in states] == ["STAND_BY", "GRIPPING"]
    assert len({each.since_us for each in states}) == 1


def test_each_change_comes_with_its_events_and_a_repeated_state_with_none(transport: LoneTransport) -> None:
    grip = transport.callbacks[GRIP_STATE.name]
    began = [
        EventMessage(1, EventKind.STATE_CHANGED, old_state=0, new_state=EndEffectorState.GRIPPING),
        EventMessage(1, EventKind.ATTEMPT_BEGAN, "cylinder", 1),
    ]
    grip(replace(status(1, EndEffectorState.GRIPPING), events=began))
    transport.ticks[STATE_HZ]()
    grip(replace(status(2, EndEffectorState.GRIPPED), events=began[:1]))
    for close in transport.closers:
        close()
    assert [each.events for each in transport.published[END_EFFECTOR_STATE.name]] == [
        began,
        (),
        began[:1],
        (),
    ]


def test_beside_each_integer_stands_its_name(transport: LoneTransport) -> None:
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
    transport: LoneTransport, caplog: pytest.LogCaptureFixture
) -> None:
    grip = transport.callbacks[GRIP_STATE.name]
    grip(status(1, EndEffectorState.STAND_BY))
    for close in transport.closers:
        close()
    with caplog.at_level(logging.INFO):
        grip(status(2, EndEffectorState.GRIPPED))
        transport.ticks[STATE_HZ]()
    assert names_of_states(transport) == [EndEffectorState.STAND_BY, EndEffectorState.OFF]
    last = transport.published[END_EFFECTOR_STATE.name][-1]
    assert (last.command, last.lift_allowed, last.secure) == (Command.NONE, False, False)
    assert caplog.records == []


def test_what_the_transport_does_not_offer_is_not_served() -> None:
    bare = LoneTransport(without=(GRIPPER_COMMAND, PARALLEL_GRIPPER_COMMAND))
    HalMainNode(cast("Any", bare))
    assert list(bare.goals) == [action.name for action in COMMAND_ACTIONS]


def test_a_position_that_is_none_ends_its_goal_and_asks_nobody(
    transport: LoneTransport, caplog: pytest.LogCaptureFixture
) -> None:
    ended: list[Any] = []
    goal = SimpleNamespace(
        request=SimpleNamespace(command=SimpleNamespace(position=0.5, max_effort=0.0)),
        end=lambda ending, result: ended.append((ending.outcome, ending.seconds, result.reached_goal)),
    )
    transport.goals[GRIPPER_COMMAND.name](goal)
    assert ended == [(Outcome.REJECTED, None, False)]
    (record,) = caplog.records
    why = "The position 0.5 is not valid for this tool: 0 grips, 1 drops."
    assert record.getMessage() == f"{GRIPPER_COMMAND.name}: REJECTED. {why}"
    assert record.levelno == logging.WARNING, "its result has no place for the reason"


def test_a_node_that_has_never_reported_is_an_alarm_only_after_the_time_of_a_start(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A launch starts its processes within seconds: the first states are OFF, and nothing is wrong."""
    from end_effector_hal.nodes.hal_main import _hal_main

    clock = [1_000_000]
    monkeypatch.setattr(_hal_main, "now_us", lambda: clock[0])
    transport = LoneTransport()
    HalMainNode(cast("Any", transport))
    shown = []
    for clock[0] in (1_000_001, 5_999_999, 6_000_000):
        transport.ticks[STATE_HZ]()
        state = transport.published[END_EFFECTOR_STATE.name][-1]
        shown.append((EndEffectorState(state.state).name, state.lift_allowed, list(state.alarms)))
    assert shown == [
        ("OFF", False, []),
        ("OFF", False, []),
        ("OFF", False, ["The node Grip has not reported yet."]),
    ]


def test_while_grip_is_silent_only_what_the_line_arbiter_keeps_stays(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    from end_effector_hal.nodes.hal_main import _hal_main

    clock = [now_us()]
    monkeypatch.setattr(_hal_main, "now_us", lambda: clock[0])
    transport = LoneTransport()
    HalMainNode(cast("Any", transport))
    held = status(1, EndEffectorState.GRIPPED)
    transport.callbacks[GRIP_STATE.name](
        replace(held, held=True, lift_allowed=True, tool_changer=ChangerState.LOCKED, outputs=[True] * 3)
    )
    clock[0] += 1_000_001
    transport.ticks[STATE_HZ]()
    gripped, silent = transport.published[END_EFFECTOR_STATE.name]
    assert (gripped.held, gripped.lift_allowed, gripped.tool_changer_name) == (True, True, "LOCKED")
    assert (silent.state_name, silent.held, silent.lift_allowed) == ("OFF", True, False)
    assert (silent.tool_changer_name, silent.outputs) == ("UNKNOWN", [True] * 3)
    assert silent.alarm_ids == ["node.silent:Grip"]
    assert [each.getMessage() for each in caplog.records if each.levelno == logging.ERROR] == [
        "the node Grip is silent"
    ]
