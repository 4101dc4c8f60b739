"""What the automata mean, as events: each kind at its exact time, and every row of the table of edges."""

from __future__ import annotations

import pytest

from end_effector_hal.control import EventKind, EventReader, ToolEvent, network_of
from end_effector_hal.control._events import EDGES
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.vocabulary import Cause, EndEffectorState
from tests.support.virtual_tool import VirtualTool
from timed_automata import Change, Step, TakenEdge

K, S = EventKind, EndEffectorState


@pytest.fixture(scope="module")
def description() -> Description:
    return load(profile_path())


def played(description: Description, scenario: str, *orders: tuple[str, float]) -> list[ToolEvent]:
    tool = VirtualTool(description, scenario)
    tool.run(1.0)
    for command, wait_s in orders:
        assert not command or tool.command(command).accepted
        tool.run(wait_s)
    return [event for status in tool.statuses for event in status.events]


def told(events: list[ToolEvent], *kinds: EventKind) -> list[tuple[int, EventKind, int, int]]:
    """Milliseconds, kind, actuator and attempt of the events of some kinds."""
    return [
        (event.at // 1000, event.kind, event.actuator, event.attempt)
        for event in events
        if event.kind in kinds
    ]


def test_attempts_begin_and_are_confirmed_or_time_out(description: Description) -> None:
    events = played(description, "fails-once:cylinder", ("grip", 9.0))
    assert told(events, K.ATTEMPT_BEGAN, K.CONFIRMED, K.TIMED_OUT) == [
        (1000, K.ATTEMPT_BEGAN, 0, 1),
        (1400, K.CONFIRMED, 0, 1),
        (1400, K.ATTEMPT_BEGAN, 1, 1),
        (6400, K.TIMED_OUT, 1, 1),
        (7400, K.ATTEMPT_BEGAN, 1, 2),
        (7920, K.CONFIRMED, 1, 2),
        (7920, K.ATTEMPT_BEGAN, 2, 1),
        (8300, K.CONFIRMED, 2, 1),
    ]


def test_the_last_time_out_stands_before_the_change_that_it_causes(description: Description) -> None:
    events = played(description, "never-confirms:bottom_vacuum", ("grip", 20.0))
    at, who = 18_000_000, {"actuator": 0}
    assert [event for event in events if event.at == at][:2] == [
        ToolEvent(at, K.TIMED_OUT, attempt=3, **who),
        ToolEvent(at, K.STATE_CHANGED, old=S.GRIPPING, new=S.GRIP_ERROR, cause=Cause.TIMED_OUT, **who),
    ]
    assert [number for _, _, _, number in told(events, K.TIMED_OUT)] == [1, 2, 3]


def test_commands_are_accepted_before_the_state_changes(description: Description) -> None:
    events = played(description, "nominal", ("grip", 3.0), ("drop", 3.0))
    grip, drop = (event for event in events if event.kind is K.COMMAND_ACCEPTED)
    assert ((grip.at, grip.command), (drop.at, drop.command)) == ((1_000_000, "grip"), (4_000_000, "drop"))
    changes = [(event.old, event.new) for event in events if event.kind is K.STATE_CHANGED]
    assert changes == [
        (S.OFF, S.STAND_BY),
        (S.STAND_BY, S.GRIPPING),
        (S.GRIPPING, S.GRIPPED),
        (S.GRIPPED, S.RELEASING),
        (S.RELEASING, S.STAND_BY),
    ]
    assert [event.kind for event in events if event.at == 1_000_000][:2] == [
        K.COMMAND_ACCEPTED,
        K.STATE_CHANGED,
    ]


def test_a_release_says_what_is_deactivated_and_what_is_not_gone(description: Description) -> None:
    events = played(description, "stuck-release:cylinder", ("grip", 3.0), ("drop", 8.0))
    assert [(kind, who) for _, kind, who, _ in told(events, K.DEACTIVATED, K.NOT_GONE)] == [
        (K.DEACTIVATED, 2),
        (K.DEACTIVATED, 1),
        (K.NOT_GONE, 1),
        (K.DEACTIVATED, 0),
    ]
    gone = next(event for event in events if event.kind is K.NOT_GONE)
    off = next(event for event in events if event.kind is K.DEACTIVATED and event.actuator == 1)
    assert gone.at - off.at == 2_000_000


def test_what_is_lost_names_its_actuator(description: Description) -> None:
    events = played(description, "lost-after:cylinder:3", ("grip", 6.0))
    lost = next(event for event in events if event.kind is K.LOST)
    assert lost.actuator == 1
    assert ToolEvent(lost.at, K.STATE_CHANGED, 1, 0, S.GRIPPED, S.GRIP_ERROR, Cause.LOST) in events


def test_the_tool_changer_has_its_own(description: Description) -> None:
    tool = VirtualTool(description)
    tool.run(1.0)
    assert tool.command("unlock").accepted
    assert [event for status in tool.statuses for event in status.events][-2:] == [
        ToolEvent(tool.at, K.COMMAND_ACCEPTED, command="unlock"),
        ToolEvent(tool.at, K.CHANGER_CHANGED, old=1, new=3),
    ]


def test_a_status_that_is_asked_for_has_no_events(description: Description) -> None:
    tool = VirtualTool(description)
    tool.run(1.0)
    assert tool.command("grip").accepted
    assert tool.statuses[-1].steps[0].attempts == 1
    assert tool.status.events == ()


# ("source", "target", "channel"): kinds, actuator, attempt; attempt 2 ends, and where one begins it becomes 3
ROWS = {
    ("Activate", "Step", "activate"): [(K.ATTEMPT_BEGAN, 1, 3)],
    ("Step", "Activate", "engaged"): [(K.CONFIRMED, 1, 2)],
    ("Step", "Decide", "engaged"): [(K.CONFIRMED, 1, 2)],
    ("Step", "Reset", "deactivate"): [(K.TIMED_OUT, 1, 2)],
    ("Step", "Step", "again"): [(K.TIMED_OUT, 1, 2), (K.ATTEMPT_BEGAN, 1, 3)],
    ("Step", "Abort", ""): [(K.TIMED_OUT, 4, 2)],
    ("Empty", "Reset", "deactivate"): [(K.CLOSED_ON_NOTHING, 1, 2)],
    ("Empty", "Abort", ""): [(K.CLOSED_ON_NOTHING, 4, 2)],
    ("Step", "Abort", "lost"): [(K.LOST, 1, 0)],
    ("Reset", "Abort", "lost"): [(K.LOST, 1, 0)],
    ("Gripped", "GripError", "lost"): [(K.LOST, 1, 0)],
    ("Gripped", "Abort", "lost"): [(K.LOST, 1, 0)],
    ("Step", "Refused", "grip_refused"): [(K.ACTIVATION_REFUSED, 4, 0)],
    ("Gripped", "GripError", "grip_refused"): [(K.ACTIVATION_REFUSED, 4, 0)],
    ("Refused", "Abort", "deactivate"): [(K.DEACTIVATED, 1, 0)],
    ("Unwind", "Check", "deactivate"): [(K.DEACTIVATED, 1, 0)],
    ("Gap", "Blowing", "blow_on"): [(K.BLOWN_OFF, 1, 0)],
    ("Releasing", "Unwind", ""): [(K.NOT_GONE, 5, 0)],
    ("Clearing", "Unwind", ""): [(K.NOT_GONE, -1, 0)],
    ("Unlocking", "Relock", ""): [(K.NOT_PROVEN, -1, 0)],
    ("Locking", "Fault", ""): [(K.NOT_PROVEN, -1, 0)],
}
_INDEXED = {"activate", "engaged", "deactivate", "again", "lost", "blow_on"}


@pytest.mark.parametrize("row", EDGES, ids="-".join)
def test_each_row_of_the_table_is_an_edge_with_its_events(row: tuple[str, str, str]) -> None:
    source, target, channel = row
    received = channel in ("lost", "engaged", "grip_refused")
    name = f"{channel}[1]" if channel in _INDEXED else channel or None
    changes = [Change("Gripper.attempt", 2, 3)] if (K.ATTEMPT_BEGAN in EDGES[row]) else []
    changes += [Change("cause_at", -1, 4)] if target in ("Abort", "Refused", "GripError") else []
    edge = TakenEdge("Gripper", source, target, 0, "")
    step = Step(
        9, None, 0, False, name if received else None, None if received else name, (edge,), tuple(changes)
    )
    found = EventReader({"Gripper.attempt": 2, "Gripper.last": 5}).of(step, 9)
    assert [(event.kind, event.actuator, event.attempt) for event in found] == ROWS[row]


def test_every_row_is_an_edge_of_the_file_and_no_such_edge_lacks_a_row(description: Description) -> None:
    edges = set()
    for template in network_of(description).document.templates:
        if template.name.content not in ("Gripper", "Changer"):
            continue
        names = {each.id: each.name.text.content for each in template.locations if each.name}
        for edge in template.edges:
            label = edge.labels.get("synchronisation")
            channel = label.text.content.strip("!? \n").partition("[")[0] if label else ""
            edges.add((names[edge.source], names[edge.target], channel))
    assert EDGES.keys() <= edges
    meant = {edge for edge in edges if edge[2] in {*_INDEXED, "grip_refused"}}
    assert meant - EDGES.keys() == {
        ("Blowing", "Blown", "grip_refused")
    }  # then it is released without blowing
