"""A line per transition and per time-out, with the cause: from statuses in virtual time; it needs no ROS."""

from __future__ import annotations

from dataclasses import replace

import pytest

from end_effector_hal.control import EventKind, ToolEvent, event_lines
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.vocabulary import ChangerState, EndEffectorState
from tests.support.virtual_tool import VirtualTool


@pytest.fixture(scope="module")
def description() -> Description:
    return load(profile_path())


def played(description: Description, scenario: str, *commands: str, each_s: float = 12.0) -> list[str]:
    tool = VirtualTool(description, scenario)
    tool.run(1.0)
    for command in commands:
        assert tool.command(command).accepted
        tool.run(each_s)
    return [line for line in lines_of(tool) if not line.startswith("tool changer: ")]


def lines_of(tool: VirtualTool) -> list[str]:
    return [line for status in tool.statuses for line in event_lines(tool.description, status)]


def test_each_transition_is_one_line(description: Description) -> None:
    assert played(description, "nominal", "grip", "drop") == [
        "OFF -> STAND_BY",
        "STAND_BY -> GRIPPING (GRIP)",
        "GRIPPING -> GRIPPED",
        "GRIPPED -> RELEASING (RELEASE)",
        "RELEASING -> STAND_BY",
    ]


def test_a_failed_attempt_is_one_line(description: Description) -> None:
    assert played(description, "fails-once:cylinder", "grip")[1:] == [
        "STAND_BY -> GRIPPING (GRIP)",
        "Cylinder was not confirmed within 5 s: attempt 1 of 3.",
        "GRIPPING -> GRIPPED",
    ]


def test_the_last_time_out_is_a_line_and_the_cause_of_what_follows(description: Description) -> None:
    why = "Top vacuum was not confirmed within 5 s in 3 attempts."
    assert played(description, "never-confirms:top_vacuum", "grip", each_s=40.0)[2:] == [
        "Top vacuum was not confirmed within 5 s: attempt 1 of 3.",
        "Top vacuum was not confirmed within 5 s: attempt 2 of 3.",
        "Top vacuum was not confirmed within 5 s: attempt 3 of 3.",
        f"GRIPPING -> GRIP_ERROR (RELEASE): {why}",
        f"GRIP_ERROR -> RELEASING (RELEASE): {why}",
        f"RELEASING -> STAND_BY: {why}",
    ]


def test_a_second_grip_counts_its_attempts_from_one(description: Description) -> None:
    lines = played(description, "never-confirms:top_vacuum", "grip", "grip", each_s=40.0)
    assert lines.count("Top vacuum was not confirmed within 5 s: attempt 2 of 3.") == 2


def test_a_release_that_goes_on_without_proof_says_so(description: Description) -> None:
    lines = played(description, "stuck-release:cylinder", "grip", "drop")
    assert lines[4:] == [
        "Cylinder was not gone within 2 s.",
        "RELEASING -> RELEASE_ERROR: Everything is deactivated, but Cylinder still shows feedback: cylinder is at "
        "599.7 kPa, cylinder_extended is on, cylinder_retracted is off; gone means less than 50 kPa.",
    ]


def test_only_a_status_of_a_step_has_lines(description: Description) -> None:
    tool = VirtualTool(description)
    tool.run(1.0)
    assert tool.status.ee == EndEffectorState.STAND_BY
    assert lines_of(tool) == ["OFF -> STAND_BY", "tool changer: UNKNOWN -> LOCKED"]
    assert not list(event_lines(description, tool.status))


def test_the_tool_changer_has_its_own(description: Description) -> None:
    tool = VirtualTool(description)
    tool.run(1.0)
    assert tool.command("unlock").accepted
    assert lines_of(tool) == [
        "OFF -> STAND_BY",
        "tool changer: UNKNOWN -> LOCKED",
        "tool changer: LOCKED -> UNLOCKING (UNLOCK)",
    ]


def test_a_lock_that_is_unknown_says_why_and_names_no_command_of_the_gripping(
    description: Description,
) -> None:
    tool = VirtualTool(description)
    tool.run(1.0)
    assert tool.command("grip").accepted
    tool.run(0.1)
    unknown = ToolEvent(tool.at, EventKind.CHANGER_CHANGED, old=ChangerState.LOCKED, new=ChangerState.UNKNOWN)
    told = replace(tool.status, changer=ChangerState.UNKNOWN, stale=("bottom", "locked"), events=(unknown,))
    assert list(event_lines(description, told)) == [
        "tool changer: LOCKED -> UNKNOWN: no valid reading of locked",
    ]
