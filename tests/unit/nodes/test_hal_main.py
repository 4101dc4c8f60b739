"""HALMain on a transport and a tool of the test: it needs no ROS."""

from __future__ import annotations

import logging
from dataclasses import replace
from math import isnan
from types import SimpleNamespace
from typing import Any, cast

import pytest

from end_effector_hal.control import Answer, EventKind, ToolEvent, unknown_now
from end_effector_hal.control.goals import Outcome
from end_effector_hal.description import Description
from end_effector_hal.nodes._hal_main import HalMainNode
from end_effector_hal.nodes.interface import (
    COMMAND_ACTIONS,
    DIAGNOSTICS,
    DIAGNOSTICS_HZ,
    END_EFFECTOR_STATE,
    GRIPPER_COMMAND,
    PARALLEL_GRIPPER_COMMAND,
    STATE_HZ,
)
from end_effector_hal.vocabulary import Alarm, Cause, ChangerState, Command, EndEffectorState, Evidence
from tests.support.lone_node import LoneTransport, status
from tests.support.parts import LOST_KPA, with_parts
from tests.support.patience import wait_until

STAND_BY, GRIPPING, GRIPPED = (
    EndEffectorState.STAND_BY,
    EndEffectorState.GRIPPING,
    EndEffectorState.GRIPPED,
)
LOST = Alarm("hal.lost", values={"why": "The HAL is silent."})


def states(transport: LoneTransport) -> list[Any]:
    return transport.published[END_EFFECTOR_STATE.name]


def names_of_states(transport: LoneTransport) -> list[EndEffectorState]:
    return [EndEffectorState(each.state) for each in states(transport)]


@pytest.fixture
def transport() -> LoneTransport:
    transport = LoneTransport()
    HalMainNode(cast("Any", transport))
    return transport


def test_every_status_is_one_state(transport: LoneTransport) -> None:
    transport.hal.says(status(STAND_BY))
    transport.hal.says(status(GRIPPING, 2))
    assert names_of_states(transport) == [STAND_BY, GRIPPING]
    first, second = states(transport)
    assert second.count == first.count + 1
    assert [each.state_name for each in states(transport)] == ["STAND_BY", "GRIPPING"]
    assert first.since_us == second.since_us
    assert (first.header.at_us, first.at_us) == (first.at_us, first.header.at_us)


def test_each_change_comes_with_its_events_and_a_repeated_state_with_none(transport: LoneTransport) -> None:
    began = (
        ToolEvent(1, EventKind.STATE_CHANGED, old=0, new=GRIPPING),
        ToolEvent(1, EventKind.ATTEMPT_BEGAN, 1, 1),
    )
    transport.hal.says(status(GRIPPING, events=began))
    transport.ticks[STATE_HZ]()
    transport.hal.says(status(GRIPPED, 2, events=began[:1]))
    for close in transport.closers:
        close()
    assert [[(each.event, each.actuator) for each in state.events] for state in states(transport)] == [
        [("state changed", ""), ("attempt began", "cylinder")],
        [],
        [("state changed", "")],
        [],
    ]
    assert [each.count for each in states(transport)] == [1, 1, 2, 3]


def test_beside_each_integer_stands_its_name(transport: LoneTransport) -> None:
    transport.hal.says(
        replace(
            status(GRIPPED, cause=Cause.TIMED_OUT, changer=ChangerState.LOCKED),
            actuators=(2, 1, 0),
            evidence=(Evidence.CONFIRMED, Evidence.PARTIAL, Evidence.UNKNOWN),
        )
    )
    (state,) = states(transport)
    assert (state.state_name, state.command_name, state.cause_name) == ("GRIPPED", "NONE", "TIMED_OUT")
    assert state.actuator_states == ["ON", "PENDING_EXTEND", "OFF"]
    assert state.evidence_names == ["CONFIRMED", "PARTIAL", "UNKNOWN"]
    assert (state.tool_position_name, state.tool_stand_name) == ("UNKNOWN", "UNKNOWN")
    assert (state.tool, state.margin_units) == ("verdin_gripper", ["Pa"] * 3)


def test_margins_and_positions_are_those_of_the_readings(transport: LoneTransport) -> None:
    transport.hal.reads(bottom=-60_000, locked=True, unlocked=False, tool_present=True, in_stand=False)
    transport.ticks[STATE_HZ]()
    transport.hal.reads(bottom=None, locked=True, unlocked=True)
    transport.ticks[STATE_HZ]()
    known, doubtful = states(transport)
    assert known.margins[0] == 10_000
    assert all(isnan(each) for each in (*known.margins[1:], *doubtful.margins))
    assert (known.tool_position_name, known.tool_stand_name) == ("LOCKED", "AWAY")
    assert (doubtful.tool_position_name, doubtful.tool_stand_name) == ("CONTRADICTORY", "UNKNOWN")


def test_a_state_names_the_part_and_its_margins_are_those_of_that_part(verdin: Description) -> None:
    transport = LoneTransport(with_parts(verdin))
    HalMainNode(cast("Any", transport))
    transport.hal.reads(top=-60_000, locked=True, unlocked=False, tool_present=True, in_stand=False)
    for part in ("panel", "lid"):
        transport.hal.says(status(GRIPPED, part=part))
    panel, lid = states(transport)
    assert (panel.part, panel.margins[2]) == ("panel", 10_000)
    assert (lid.part, lid.margins[2]) == ("lid", 60_000 - 1_000 * LOST_KPA)


def test_a_grip_asks_for_the_part_of_its_goal_and_a_position_for_the_default_one(verdin: Description) -> None:
    transport = LoneTransport(with_parts(verdin))
    HalMainNode(cast("Any", transport))
    transport.hal.answer = Answer(False, "There is no such part.")
    ended: list[Any] = []

    def ask(action: str, **request: Any) -> None:
        count = len(ended)
        goal = SimpleNamespace(
            request=SimpleNamespace(**request),
            end=lambda ending, _: ended.append((ending.outcome.name, ending.reason)),
        )
        transport.goals[action](goal)
        wait_until("its end", lambda: len(ended) > count)

    ask("TriggerGrip", part="lid")
    ask("TriggerGrip", part="")
    ask(GRIPPER_COMMAND.name, command=SimpleNamespace(position=0.0, max_effort=0.0))
    ask("Drop", part="lid")
    assert transport.hal.asked == [("grip", "lid"), "grip", ("grip", "panel")]
    assert ended == [
        *[("REJECTED", "There is no such part.")] * 3,
        ("REJECTED", "Only a grip is for a part: Drop needs an empty `part`."),
    ]


def test_off_is_the_last_state_whatever_comes_later(
    transport: LoneTransport, caplog: pytest.LogCaptureFixture
) -> None:
    transport.hal.says(status(STAND_BY))
    for close in transport.closers:
        close()
    with caplog.at_level(logging.INFO):
        transport.hal.says(status(GRIPPED, 2))
        transport.ticks[STATE_HZ]()
    assert names_of_states(transport) == [STAND_BY, EndEffectorState.OFF]
    last = states(transport)[-1]
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
    assert transport.hal.asked == []
    (record,) = caplog.records
    why = "The position 0.5 is not valid for this tool: 0 grips, 1 drops."
    assert record.getMessage() == f"{GRIPPER_COMMAND.name}: REJECTED. {why}"
    assert record.levelno == logging.WARNING, "its result has no place for the reason"


def test_while_the_hal_is_not_heard_only_what_the_line_arbiter_keeps_stays(
    transport: LoneTransport, caplog: pytest.LogCaptureFixture
) -> None:
    held = status(GRIPPED, held=True, lift_allowed=True, changer=ChangerState.LOCKED)
    held = replace(held, outputs=(True,) * 3)
    transport.hal.says(held)
    transport.hal.alive = False
    transport.hal.says(replace(unknown_now(held), alarms=(LOST,)))
    gripped, lost = states(transport)
    assert (gripped.held, gripped.lift_allowed, gripped.tool_changer_name) == (True, True, "LOCKED")
    assert (lost.state_name, lost.held, lost.lift_allowed) == ("OFF", True, False)
    assert (lost.tool_changer_name, lost.outputs) == ("UNKNOWN", (True,) * 3)
    assert lost.alarm_ids == ["hal.lost"]
    assert [each.getMessage() for each in caplog.records if each.levelno == logging.WARNING] == [LOST.text]


def test_its_health_says_whether_the_hal_was_ever_heard(transport: LoneTransport) -> None:
    def health() -> tuple[int, str]:
        transport.ticks[DIAGNOSTICS_HZ]()
        (found,) = transport.published[DIAGNOSTICS.name][-1].status
        return found.level, found.message

    transport.hal.alive = False
    assert health() == (1, "The HAL has not reported yet.")
    transport.hal.says(replace(unknown_now(status(GRIPPED)), alarms=(LOST,)))
    assert health() == (2, LOST.text)
    transport.hal.alive = True
    transport.hal.says(status(STAND_BY))
    assert health() == (0, "As it should be.")
    transport.hal.says(status(EndEffectorState.GRIP_ERROR))
    assert health()[0] == 2
