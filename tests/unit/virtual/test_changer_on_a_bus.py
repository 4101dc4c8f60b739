"""A tool changer and a blow-off whose valves are coils on a bus: the interlocks and endings are those of lines."""

from __future__ import annotations

import pytest

from end_effector_hal.codecs import load_tool
from end_effector_hal.description import Description
from end_effector_hal.vocabulary import ChangerState, EndEffectorState
from end_effector_lab.virtual import VirtualTool
from tests.support.places import ROOT
from tests.unit.virtual.test_unread_outputs import until

TOOL = ROOT / "examples" / "tools" / "remote_changer" / "end_effector.yaml"
UNLOCK, CUP, AIR, LAMP = (f"modbus:1/0x000{number}" for number in range(4))
GRIPPED, STAND_BY = EndEffectorState.GRIPPED, EndEffectorState.STAND_BY
S = 1_000_000
ANSWERED_S = 0.2
"""Longest time in which a device of a bus that is read obeys."""


def played(description: Description) -> VirtualTool:
    tool = VirtualTool(description)
    until(tool, STAND_BY)
    assert tool.run_until(tool.at + 5 * S, lambda: tool.status.changer is ChangerState.LOCKED)
    return tool


@pytest.fixture
def tool() -> VirtualTool:
    return played(load_tool(TOOL))


def kept(description: Description) -> Description:
    """Return the tool with a station and a dying program that leave the unlock output active."""
    changer = description.tool_changer
    assert changer is not None
    assert changer.modbus is not None
    output = changer.modbus.model_copy(update={"on_link_loss": "keep"})
    endings = changer.endings.model_copy(update={"process_death": "hold"})
    held = changer.model_copy(update={"modbus": output, "endings": endings})
    return description.model_copy(update={"tool_changer": held})


def unlocked(tool: VirtualTool) -> VirtualTool:
    assert tool.command("unlock").accepted
    assert tool.run_until(tool.at + S, lambda: tool.levels[UNLOCK])
    tool.run(ANSWERED_S)
    return tool


def changes(tool: VirtualTool, since: int = 0) -> list[tuple[str, bool]]:
    return [(each.line, each.level) for each in tool.edges[since:]]


def test_a_part_is_blown_off_between_the_gaps_and_the_changer_unlocks_and_locks(tool: VirtualTool) -> None:
    assert tool.command("grip").accepted
    until(tool, GRIPPED)
    assert tool.command("drop").accepted
    until(tool, STAND_BY)
    assert changes(tool) == [(CUP, True), (CUP, False), (AIR, True), (AIR, False)]
    off, on = tool.edges[1].at, tool.edges[2].at
    assert on - off >= 50_000, "IL-08"
    assert tool.command("unlock").accepted
    assert tool.run_until(tool.at + 5 * S, lambda: tool.status.changer is ChangerState.UNLOCKED)
    tool.run(4.0)
    assert changes(tool, 4) == [(UNLOCK, True), (UNLOCK, False)]
    assert not tool.latched


def test_it_does_not_unlock_while_the_cup_is_active(tool: VirtualTool) -> None:
    assert tool.command("grip").accepted
    until(tool, GRIPPED)
    assert not tool.command("unlock").accepted
    assert not tool.levels[UNLOCK]


def test_the_arbiter_ends_an_unlock_whose_program_has_died(tool: VirtualTool) -> None:
    tool = unlocked(played(kept(tool.description)))
    tool.kill("hal")
    tool.run(5.0)
    assert changes(tool) == [(UNLOCK, True), (UNLOCK, False)]
    assert tool.edges[1].at - tool.edges[0].at <= 3.2 * S
    (why,) = tool.latched.values()
    assert why.startswith("IL-03")


def test_a_dead_programs_changer_locks(tool: VirtualTool) -> None:
    unlocked(tool)
    tool.kill("hal")
    tool.run(1.0)
    assert changes(tool) == [(UNLOCK, True), (UNLOCK, False)]


def test_an_unlock_that_a_lost_bus_cannot_end_is_said_and_ended_when_it_is_back(tool: VirtualTool) -> None:
    tool = unlocked(played(kept(tool.description)))
    tool.kill("hal")
    tool.choose("silent-after:0")
    tool.run(6.0)
    assert tool.levels[UNLOCK], "nothing reaches the station"
    latched = tool.latched
    assert "until its device acknowledges it" in latched[f"IL-03 {UNLOCK}"]
    assert "no device acknowledges it" in latched[f"output {UNLOCK}"]
    tool.choose("nominal")
    tool.run(2.0)
    assert not tool.levels[UNLOCK]


@pytest.mark.parametrize("dies", [("arbiter",), ("arbiter", "hal")])
def test_another_arbiter_ends_the_unlock_of_the_one_before(tool: VirtualTool, dies: tuple[str, ...]) -> None:
    tool = unlocked(played(kept(tool.description)))
    for name in dies:
        tool.kill(name)
    tool.run(5.0)
    assert tool.levels[UNLOCK]
    tool.start("arbiter")
    tool.run(2.0)
    assert changes(tool)[:2] == [(UNLOCK, True), (UNLOCK, False)]
    assert not tool.levels[UNLOCK]


def test_a_station_that_switches_off_by_itself_locks(tool: VirtualTool) -> None:
    unlocked(tool)
    tool.choose("silent-after:0")
    tool.run(2.0)
    assert not tool.levels[UNLOCK]
    assert LAMP not in [line for line, _ in changes(tool)]
