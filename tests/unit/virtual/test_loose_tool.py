"""A tool that is absent, unlocked or in FAULT: no grip, no lift, and an alarm while a part is held (IL-05)."""

from __future__ import annotations

import pytest

from end_effector_hal.codecs import load_tool
from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.vocabulary import ChangerState, EndEffectorState
from end_effector_lab.virtual import VirtualTool
from tests.support.places import ROOT

SHIPPED = load(profile_path())
TWO_COILS = load_tool(ROOT / "examples/tools/two_coil_changer/end_effector.yaml")
OPEN = "locked-shows:tool_changer:0,unlocked-shows:tool_changer:1"


@pytest.fixture(params=[SHIPPED, TWO_COILS], ids=["shipped", "two_coil_changer"])
def description(request: pytest.FixtureRequest) -> Description:
    found: Description = request.param
    return found


def ready(description: Description, scenario: str = "nominal") -> VirtualTool:
    tool = VirtualTool(description, scenario)
    tool.run(2.0)
    assert tool.status.ee == EndEffectorState.STAND_BY, tool.status.alarm_texts
    return tool


def gripped(description: Description) -> VirtualTool:
    tool = ready(description)
    assert tool.command("grip").accepted
    tool.run(3.0)
    assert (tool.status.ee, tool.status.lift_allowed) == (EndEffectorState.GRIPPED, True)
    return tool


def held(tool: VirtualTool) -> tuple[bool, bool, bool]:
    """What counts for a lift; and every output of the grip is active."""
    assert tool.status.ee == EndEffectorState.GRIPPED
    assert all(tool.status.outputs)
    return tool.status.held, tool.status.lift_allowed, tool.status.secure


def test_without_a_tool_neither_lock_nor_grip(description: Description) -> None:
    tool = ready(description, "no-tool")
    changer = description.tool_changer
    assert changer
    assert tool.status.changer is ChangerState.UNKNOWN
    gone = f"there is no tool ({changer.present_bit} is off)."
    assert tool.command("lock").reason == f"A lock is refused: {gone}"
    assert tool.command("grip").reason == f"IL-05: {gone}"
    # a valve with two coils whose position is unknown is driven to where the sensors prove it to be
    locks = changer.opposite.line if changer.opposite else ""
    assert not any(level for line, level in tool.levels.items() if line != locks)
    tool.choose("nominal")
    tool.run(0.5)
    assert tool.command("grip").accepted


def test_a_tool_that_vanishes_while_a_part_is_held(description: Description) -> None:
    tool = gripped(description)
    tool.choose("no-tool")
    tool.run(0.5)
    assert held(tool) == (True, False, False)
    assert any("there is no tool" in alarm and "do not lift" in alarm for alarm in tool.status.alarm_texts)
    tool.choose("nominal")
    tool.run(0.5)
    assert held(tool) == (True, True, True)
    assert any("over" in alarm.lower() for alarm in tool.status.alarm_texts)
    assert tool.command("drop").accepted
    tool.run(3.0)
    assert (tool.status.ee, tool.status.alarm_texts) == (EndEffectorState.STAND_BY, ())


def test_a_tool_that_is_unlocked_while_a_part_is_held_stays_in_fault(description: Description) -> None:
    tool = gripped(description)
    tool.choose(OPEN)
    tool.run(0.5)
    assert held(tool) == (True, False, False)
    assert tool.status.changer is ChangerState.FAULT
    tool.choose("nominal")
    tool.run(0.5)
    assert held(tool) == (True, False, False)
    assert any("the tool" in alarm and "while a part is held" in alarm for alarm in tool.status.alarm_texts)
    assert tool.command("lock").accepted
    tool.run(0.5)
    assert held(tool) == (True, True, True)


def test_no_grip_begins_while_the_tool_changer_is_in_fault(description: Description) -> None:
    tool = ready(description)
    tool.choose(OPEN)
    tool.run(0.5)
    tool.choose("nominal")
    tool.run(0.5)
    assert tool.status.changer is ChangerState.FAULT
    assert tool.command("grip").reason == "IL-05: the tool changer is in FAULT."


def test_where_only_the_presence_is_shown_it_counts_alone() -> None:
    changer = SHIPPED.tool_changer
    assert changer
    blind = changer.model_copy(update={"locked_bit": "none", "unlocked_bit": "none"})
    description = SHIPPED.model_copy(update={"tool_changer": blind})
    tool = ready(description, "no-tool")
    assert tool.command("grip").reason == "IL-05: there is no tool (tool_present is off)."
    tool.choose("nominal")
    tool.run(0.5)
    assert tool.command("grip").accepted
    tool.run(3.0)
    assert held(tool) == (True, True, True)
    tool.choose("no-tool")
    tool.run(0.5)
    assert held(tool) == (True, False, False)


def test_an_unlock_without_a_tool_that_is_not_proven_ends_by_itself(description: Description) -> None:
    """The changer is UNKNOWN again, as before its adoption; its output must be inactive all the same."""
    changer = description.tool_changer
    assert changer
    tool = ready(description, "no-tool,locked-shows:tool_changer:1,unlocked-shows:tool_changer:0")
    assert tool.command("unlock").accepted
    tool.run(changer.prove_s / 2)
    assert tool.status.unlock_output
    assert tool.levels[changer.line]
    assert tool.run_until(tool.at + 5_000_000, lambda: not tool.status.unlock_output)
    tool.run(0.1)
    assert tool.status.changer is ChangerState.UNKNOWN
    assert not tool.levels[changer.line]
    assert not tool.latched
