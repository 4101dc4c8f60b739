"""What the automata mean, as events, and the line of each; what a controller says that it would refuse."""

from __future__ import annotations

from dataclasses import replace

import pytest

from end_effector_hal.control import (
    COMMANDS,
    Controller,
    EventKind,
    EventReader,
    ToolEvent,
    event_lines,
    network_of,
)
from end_effector_hal.control._events import EDGES
from end_effector_hal.description import Description
from end_effector_hal.vocabulary import Cause, ChangerState, EndEffectorState
from tests.support.nightly import first_of
from tests.support.virtual_tool import VirtualTool
from timed_automata import Change, Step, TakenEdge

K, S = EventKind, EndEffectorState


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


def test_attempts_begin_and_are_confirmed_or_time_out(verdin: Description) -> None:
    events = played(verdin, "fails-once:cylinder", ("grip", 9.0))
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


def test_the_last_time_out_stands_before_the_change_that_it_causes(verdin: Description) -> None:
    events = played(verdin, "never-confirms:bottom_vacuum", ("grip", 20.0))
    at, who = 18_000_000, {"actuator": 0}
    assert [event for event in events if event.at == at][:2] == [
        ToolEvent(at, K.TIMED_OUT, attempt=3, **who),
        ToolEvent(at, K.STATE_CHANGED, old=S.GRIPPING, new=S.GRIP_ERROR, cause=Cause.TIMED_OUT, **who),
    ]
    assert [number for _, _, _, number in told(events, K.TIMED_OUT)] == [1, 2, 3]


def test_commands_are_accepted_before_the_state_changes(verdin: Description) -> None:
    events = played(verdin, "nominal", ("grip", 3.0), ("drop", 3.0))
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


def test_a_release_says_what_is_deactivated_and_what_is_not_gone(verdin: Description) -> None:
    events = played(verdin, "stuck-release:cylinder", ("grip", 3.0), ("drop", 8.0))
    assert [(kind, who) for _, kind, who, _ in told(events, K.DEACTIVATED, K.NOT_GONE)] == [
        (K.DEACTIVATED, 2),
        (K.DEACTIVATED, 1),
        (K.NOT_GONE, 1),
        (K.DEACTIVATED, 0),
    ]
    gone = next(event for event in events if event.kind is K.NOT_GONE)
    off = next(event for event in events if event.kind is K.DEACTIVATED and event.actuator == 1)
    assert gone.at - off.at == 2_000_000


def test_what_is_lost_names_its_actuator(verdin: Description) -> None:
    events = played(verdin, "lost-after:cylinder:3", ("grip", 6.0))
    lost = next(event for event in events if event.kind is K.LOST)
    assert lost.actuator == 1
    assert ToolEvent(lost.at, K.STATE_CHANGED, 1, 0, S.GRIPPED, S.GRIP_ERROR, Cause.LOST) in events


def test_the_tool_changer_has_its_own(verdin: Description) -> None:
    tool = VirtualTool(verdin)
    tool.play(1.0, "unlock")
    assert [event for status in tool.statuses for event in status.events][-2:] == [
        ToolEvent(tool.at, K.COMMAND_ACCEPTED, command="unlock"),
        ToolEvent(tool.at, K.CHANGER_CHANGED, old=1, new=3),
    ]


def test_a_status_that_is_asked_for_has_no_events(verdin: Description) -> None:
    tool = VirtualTool(verdin)
    tool.play(1.0, "grip")
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


def test_every_row_is_an_edge_of_the_file_and_no_such_edge_lacks_a_row(verdin: Description) -> None:
    edges = set()
    for template in network_of(verdin).document.templates:
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


# A line per transition and per time-out, with the cause: from statuses in virtual time; it needs no ROS.


def lines_after(description: Description, scenario: str, *commands: str, each_s: float = 12.0) -> list[str]:
    tool = VirtualTool(description, scenario)
    tool.run(1.0)
    for command in commands:
        assert tool.command(command).accepted
        tool.run(each_s)
    return [line for line in lines_of(tool) if not line.startswith("tool changer: ")]


def lines_of(tool: VirtualTool) -> list[str]:
    return [line for status in tool.statuses for line in event_lines(tool.description, status)]


def test_each_transition_is_one_line(verdin: Description) -> None:
    assert lines_after(verdin, "nominal", "grip", "drop") == [
        "OFF -> STAND_BY", "STAND_BY -> GRIPPING (GRIP)", "GRIPPING -> GRIPPED",
        "GRIPPED -> RELEASING (RELEASE)", "RELEASING -> STAND_BY",
    ]  # fmt: skip


def test_a_failed_attempt_is_one_line(verdin: Description) -> None:
    assert lines_after(verdin, "fails-once:cylinder", "grip")[1:] == [
        "STAND_BY -> GRIPPING (GRIP)",
        "Cylinder was not confirmed within 5 s: attempt 1 of 3.",
        "GRIPPING -> GRIPPED",
    ]


def test_the_last_time_out_is_a_line_and_the_cause_of_what_follows(verdin: Description) -> None:
    why = "Top vacuum was not confirmed within 5 s in 3 attempts."
    assert lines_after(verdin, "never-confirms:top_vacuum", "grip", each_s=40.0)[2:] == [
        "Top vacuum was not confirmed within 5 s: attempt 1 of 3.",
        "Top vacuum was not confirmed within 5 s: attempt 2 of 3.",
        "Top vacuum was not confirmed within 5 s: attempt 3 of 3.",
        f"GRIPPING -> GRIP_ERROR (RELEASE): {why}",
        f"GRIP_ERROR -> RELEASING (RELEASE): {why}",
        f"RELEASING -> STAND_BY: {why}",
    ]


def test_a_second_grip_counts_its_attempts_from_one(verdin: Description) -> None:
    lines = lines_after(verdin, "never-confirms:top_vacuum", "grip", "grip", each_s=40.0)
    assert lines.count("Top vacuum was not confirmed within 5 s: attempt 2 of 3.") == 2


def test_a_release_that_goes_on_without_proof_says_so(verdin: Description) -> None:
    lines = lines_after(verdin, "stuck-release:cylinder", "grip", "drop")
    assert lines[4:] == [
        "Cylinder was not gone within 2 s.",
        "RELEASING -> RELEASE_ERROR: Everything is deactivated, but Cylinder still shows feedback: cylinder is at "
        "599.7 kPa, cylinder_extended is on, cylinder_retracted is off; gone means less than 50 kPa.",
    ]


def test_only_a_status_of_a_step_has_lines(verdin: Description) -> None:
    tool = VirtualTool(verdin)
    tool.run(1.0)
    assert tool.status.ee == EndEffectorState.STAND_BY
    assert lines_of(tool) == ["OFF -> STAND_BY", "tool changer: UNKNOWN -> LOCKED"]
    assert not list(event_lines(verdin, tool.status))


def test_the_tool_changer_has_its_own_lines(verdin: Description) -> None:
    tool = VirtualTool(verdin)
    tool.play(1.0, "unlock")
    assert lines_of(tool) == [
        "OFF -> STAND_BY",
        "tool changer: UNKNOWN -> LOCKED",
        "tool changer: LOCKED -> UNLOCKING (UNLOCK)",
    ]


def test_a_lock_that_is_unknown_says_why_and_names_no_command_of_the_gripping(
    verdin: Description,
) -> None:
    tool = VirtualTool(verdin)
    tool.play(1.0, "grip", 0.1)
    unknown = ToolEvent(tool.at, EventKind.CHANGER_CHANGED, old=ChangerState.LOCKED, new=ChangerState.UNKNOWN)
    told = replace(tool.status, changer=ChangerState.UNKNOWN, stale=("bottom", "locked"), events=(unknown,))
    assert list(event_lines(verdin, told)) == [
        "tool changer: LOCKED -> UNKNOWN: no valid reading of locked",
    ]


# What a controller says that it would refuse is what it does refuse, word for word, and asking changes nothing.


@pytest.mark.parametrize(
    "scenario",
    first_of(
        [
            "nominal", "lost-after:top_vacuum:3", "silent-after:4", "never-confirms:cylinder",
            "not-in-stand", "supply:300",
        ],
        2,
        2,
    ),
)  # fmt: skip
def test_it_says_beforehand_what_it_answers(verdin: Description, scenario: str) -> None:
    """Asked every 0.6 s of a run, of a controller and of its copy, which is then given the command."""
    tool, network = VirtualTool(verdin, scenario), network_of(verdin)
    said = set()
    for moment in range(25):
        if moment in (2, 15):
            tool.command("grip" if moment == 2 else "drop")
        if moment in (20, 22):
            tool.command("unlock" if moment == 20 else "lock")
        tool.run(0.6)
        before = tool.controller.snapshot()
        assert before is not None
        for word in COMMANDS:
            refusal = tool.controller.refusal(word)
            copy = Controller(verdin, network)
            copy.resume(before)
            answer, _ = copy.command(word, tool.at)
            assert (answer.accepted, answer.reason) == (not refusal, refusal), (moment, word)
            said.add(refusal)
        assert tool.controller.snapshot() == before
    assert len(said) > 5
