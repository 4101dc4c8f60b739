"""A resume, in virtual time: from a GRIP_ERROR that a loss caused back to GRIPPED, and why it is refused."""

from __future__ import annotations

import re

import pytest

from end_effector_hal.control import EventKind
from end_effector_hal.description import Description
from end_effector_hal.vocabulary import Cause, EndEffectorState
from end_effector_lab.virtual import VirtualTool
from tests.support.declared import declared

GRIPPED, GRIP_ERROR = EndEffectorState.GRIPPED, EndEffectorState.GRIP_ERROR
WEAK = "shows:top_vacuum:-30"
NOT_CONFIRMED = re.compile(
    r"Top vacuum is not confirmed again: top is at -30\.\d kPa; confirmed means at least 55 kPa below ambient\."
)


def gripped(description: Description) -> VirtualTool:
    tool = VirtualTool(description)
    tool.run(1.0)
    assert tool.command("grip").accepted
    tool.run(3.0)
    assert tool.status.ee is GRIPPED
    return tool


def lost(description: Description, fault: str = WEAK) -> VirtualTool:
    """A sensor has shown a loss for half a second."""
    tool = gripped(description)
    tool.choose(fault)
    tool.run(0.5)
    assert (tool.status.ee, tool.status.cause) == (GRIP_ERROR, Cause.LOST)
    return tool


def refused(tool: VirtualTool) -> str:
    before, edges = tool.status.ee, len(tool.edges)
    answer = tool.command("resume")
    assert (answer.accepted, tool.status.ee, len(tool.edges)) == (False, before, edges)
    return answer.reason


def test_a_resume_leads_back_to_gripped_and_writes_nothing(verdin: Description) -> None:
    tool = lost(verdin)
    edges = list(tool.edges)
    assert NOT_CONFIRMED.fullmatch(refused(tool))
    tool.choose("nominal")
    tool.run(60.0)
    assert tool.status.ee is GRIP_ERROR, "never by itself"
    seen = len(tool.statuses)
    assert tool.command("resume").accepted
    events = [event for status in tool.statuses[seen:] for event in status.events]
    assert [(event.kind, event.command, event.old, event.new) for event in events] == [
        (EventKind.COMMAND_ACCEPTED, "resume", -1, -1),
        (EventKind.STATE_CHANGED, "", GRIP_ERROR, GRIPPED),
    ]
    status = tool.status
    assert (status.ee, status.held, status.lift_allowed) == (GRIPPED, True, True)
    assert (status.cause, status.reason, status.alarms) == (Cause.NONE, "", ())
    tool.run(5.0)
    assert (tool.status.ee, tool.edges) == (GRIPPED, edges)
    tool.choose(WEAK)
    tool.run(0.5)
    assert tool.status.ee is GRIP_ERROR, "the next loss is one again"
    tool.choose("nominal")
    assert tool.command("drop").accepted
    tool.run(3.0)
    assert tool.status.ee is EndEffectorState.STAND_BY


def test_without_a_loss_there_is_nothing_to_resume(verdin: Description) -> None:
    tool = gripped(verdin)
    assert refused(tool) == (
        "Nothing was lost: a resume is accepted in GRIP_ERROR only; the end-effector is GRIPPED."
    )
    tool.command("drop")
    tool.run(3.0)
    assert refused(tool).endswith("the end-effector is STAND_BY.")


def test_a_reading_that_is_missing_is_no_evidence(verdin: Description) -> None:
    tool = lost(verdin)
    tool.choose("silent-after:0")
    tool.run(2.0)
    assert "is not confirmed again" in refused(tool)
    assert "has no valid reading" in refused(tool)


def test_a_loose_tool_is_named(verdin: Description) -> None:
    tool = lost(verdin)
    tool.choose("locked-shows:tool_changer:0")
    tool.run(1.0)
    assert refused(tool) == "IL-05: the tool is not proven to be locked (its sensors say FAULTY)."


def test_a_program_that_has_restarted_has_seen_no_loss(verdin: Description) -> None:
    """What it finds is not what it has gripped: only a Drop leaves its GRIP_ERROR."""
    tool = lost(verdin)
    tool.kill("hal")
    tool.run(0.1)
    tool.start("hal")
    tool.run(7.0)
    assert (tool.status.ee, tool.status.cause) == (GRIP_ERROR, Cause.UNPROVEN_AT_START)
    tool.choose("nominal")
    tool.run(1.0)
    assert refused(tool) == (
        "A resume is accepted only after a loss that left every output active. Outputs were active at the start and "
        "the sensors do not confirm a grip. Drop first."
    )


def test_a_grip_that_was_given_up_was_never_whole() -> None:
    tool = VirtualTool(declared({"gripping": {"cancel": "hold"}}))
    tool.run(1.0)
    assert tool.command("grip").accepted
    tool.run(0.6)
    assert tool.command("cancel").accepted
    tool.run(1.0)
    assert tool.status.ee is GRIP_ERROR
    assert refused(tool).startswith("A resume is accepted only after a loss that left every output active.")


@pytest.mark.parametrize("outputs", ["one", "all"])
def test_a_loss_that_releases_something_is_not_resumed(outputs: str) -> None:
    parts = ("top_vacuum",) if outputs == "one" else ("bottom_vacuum", "cylinder", "top_vacuum")
    tool = gripped(declared(**{name: {"held": {"lost": "release"}} for name in parts}))
    tool.choose(WEAK)
    tool.run(5.0)
    tool.choose("nominal")
    tool.run(2.0)
    assert refused(tool)
