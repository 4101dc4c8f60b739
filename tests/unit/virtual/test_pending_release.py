"""A release on a bus that its device has not acknowledged when the program or the line arbiter starts again."""

from __future__ import annotations

from pathlib import Path

import pytest

from end_effector_hal.codecs import load_tool
from end_effector_hal.vocabulary import EndEffectorState
from end_effector_lab.testbench import Sent
from end_effector_lab.testbench.devices import read_request
from end_effector_lab.virtual import VirtualTool
from tests.support.places import ROOT
from tests.unit.virtual.test_unread_outputs import TOOL, until

GRIP_ERROR, GRIPPED, RELEASE_ERROR, STAND_BY = (
    EndEffectorState.GRIP_ERROR,
    EndEffectorState.GRIPPED,
    EndEffectorState.RELEASE_ERROR,
    EndEffectorState.STAND_BY,
)
STUCK = "stuck-release:cup_a,stuck-release:cup_b"
DEATHS = [("hal",), ("arbiter",), ("arbiter", "hal"), ("hal", "arbiter")]


class Devices:
    """The devices of the only bus; they obey a write and their answer is lost, or they do not hear it at all."""

    def __init__(self, tool: VirtualTool) -> None:
        (devices,) = tool._boards.values()
        self.silent = self.deaf = False
        self._answer = devices.answer
        devices.answer = self.answer  # type: ignore[method-assign]

    def answer(self, request: bytes, at: int) -> Sent | None:
        asked = read_request(request)
        writes = asked is not None and asked.values is not None
        if writes and self.deaf:
            return None
        sent = self._answer(request, at)
        return None if writes and self.silent else sent


def gripped(
    folder: Path, scenario: str = "nominal", *, verify: bool, unheard: bool = False
) -> tuple[VirtualTool, Devices]:
    """Return a tool that holds a part; ``unheard``: the answers to its activations were lost."""
    text = TOOL
    if verify:
        for number, cup in enumerate(("a", "b")):
            told = f"  told_{cup}: {{modbus: {{unit: 65, address: {number}, bitmask: 0xFF00}}, on: [1]}}\n"
            text = text.replace("sequence:", f"{told}sequence:")
            text = text.replace(f"{number}, command_on", f"{number}, verify: told_{cup}, command_on")
    path = folder / "end_effector.yaml"
    path.write_text(text)
    tool = VirtualTool(load_tool(path), scenario)
    devices = Devices(tool)
    until(tool, STAND_BY)
    tool.run(1.0)
    devices.silent = unheard
    assert tool.command("grip").accepted
    until(tool, GRIPPED)
    return tool, devices


def die(tool: VirtualTool, names: tuple[str, ...]) -> None:
    """These processes die one after the other, and start again."""
    for name in names:
        tool.kill(name)
        tool.run(0.01)
    for name in names:
        tool.start(name)


def state_after(names: tuple[str, ...], *, verify: bool) -> EndEffectorState:
    """The state in which the death of these processes, while cup_b is released, leaves the tool."""
    if names != ("arbiter",):
        return STAND_BY  # the last will has released cup_a
    # without verify nobody knows cup_a, so that the program starts again, and cup_a waits for a Drop
    return RELEASE_ERROR if verify else GRIP_ERROR


@pytest.mark.parametrize("verify", [False, True])
@pytest.mark.parametrize("names", DEATHS)
def test_a_start_does_not_undo_a_release_that_was_obeyed(
    tmp_path: Path, names: tuple[str, ...], verify: bool
) -> None:
    """IL-11: the answers of the devices are lost, and both sensors still show a part."""
    tool, devices = gripped(tmp_path, STUCK, verify=verify)
    before, devices.silent = len(tool.edges), True
    assert tool.command("drop").accepted
    tool.run(0.2)
    for _ in range(2):  # the second death meets the record of an arbiter that has written the release again
        die(tool, names)
        tool.run(8.0)
        assert tool.status.ee == state_after(names, verify=verify)
    assert tool.command("grip").reason
    devices.silent = False
    assert tool.command("drop").accepted
    tool.run(8.0)
    assert [edge.level for edge in tool.edges[before:]] == [False, False]


@pytest.mark.parametrize("verify", [False, True])
@pytest.mark.parametrize("names", DEATHS)
def test_a_start_does_not_cancel_a_release_that_no_device_has_obeyed(
    tmp_path: Path, names: tuple[str, ...], verify: bool
) -> None:
    tool, devices = gripped(tmp_path, verify=verify)
    before, devices.deaf = len(tool.edges), True
    assert tool.command("drop").accepted
    tool.run(0.2)
    die(tool, names)
    tool.run(8.0)
    assert tool.edges[before:] == []
    state, told = state_after(names, verify=verify), tool.status.alarm_texts
    assert tool.status.ee == state
    assert any("(cup_b) is to be deactivated, and no device acknowledges it" in alarm for alarm in told)
    if state == STAND_BY:
        assert tool.command("grip").reason.startswith("IL-07"), "the sensors still show a part"
    devices.deaf = False
    tool.run(4.0)  # one release after the other, as they were commanded
    released = tool.edges[before:]
    assert [edge.level for edge in released] == [False] * (1 if state == GRIP_ERROR else 2)
    assert tool.command("drop").accepted is (state != STAND_BY)  # else nothing is left to be released
    until(tool, STAND_BY)
    assert [edge.level for edge in tool.edges[before:]] == [False, False]
    tool.run(1.0)
    assert tool.reset().accepted
    assert tool.command("grip").accepted
    until(tool, GRIPPED)


@pytest.mark.parametrize("unheard", [False, True])
@pytest.mark.parametrize("verify", [False, True])
@pytest.mark.parametrize("names", DEATHS)
def test_what_was_never_released_stays_held(
    tmp_path: Path, names: tuple[str, ...], verify: bool, unheard: bool
) -> None:
    tool, devices = gripped(tmp_path, verify=verify, unheard=unheard)
    before, devices.deaf = len(tool.edges), True
    die(tool, names)
    tool.run(8.0)
    devices.deaf = devices.silent = False
    tool.run(8.0)
    assert tool.edges[before:] == []
    assert (tool.status.ee, tool.status.held, tool.status.outputs) == (GRIPPED, True, (True, True))
    assert tool.command("drop").accepted
    until(tool, STAND_BY)
    assert [edge.level for edge in tool.edges[before:]] == [False, False]


@pytest.mark.parametrize("restarts", [1, 2])
def test_releases_that_are_owed_keep_order_and_interval_over_a_restart(tmp_path: Path, restarts: int) -> None:
    """A Drop and the last will have commanded both while no device heard it, cup_b first."""
    tool, devices = gripped(tmp_path, verify=True)
    before, devices.deaf = len(tool.edges), True
    assert tool.command("drop").accepted
    tool.run(0.2)
    tool.kill("hal")
    tool.run(8.0)
    for _ in range(restarts):
        tool.run(0.1)
        tool.kill("arbiter")
        tool.start("arbiter")
    devices.deaf = False
    tool.run(4.0)
    cup_a, cup_b = (tool.description.actuators[name].line for name in ("cup_a", "cup_b"))
    released = tool.edges[before:]
    assert [(edge.line, edge.level) for edge in released] == [(cup_b, False), (cup_a, False)]
    apart_s = (released[1].at - released[0].at) / 1e6
    assert apart_s == pytest.approx(tool.description.actuators["cup_b"].release_s, abs=0.2)


def test_a_last_will_waits_once_for_its_own_first_step() -> None:
    """The release of the fingers is owed at the restart, and it is the step before that of the cups."""
    tool = VirtualTool(load_tool(ROOT / "examples" / "cells" / "three_parts" / "end_effector.yaml"))
    until(tool, STAND_BY)
    actuators = tool.description.actuators
    fingers = actuators["fingers"]
    assert tool.command("grip", part="crate").accepted
    assert tool.run_until(
        tool.at + 10_000_000, lambda: bool(tool.edges) and tool.edges[-1].line == fingers.line
    )
    tool.run(1.0)
    assert tool.status.ee == EndEffectorState.GRIPPING
    for name in ("hal", "arbiter"):
        tool.kill(name)
    tool.run(1.0)
    begun, before = tool.at, len(tool.edges)
    for name in ("arbiter", "hal"):
        tool.start(name)
    tool.run(20.0)
    offs = [(edge.line, (edge.at - begun) / 1e6) for edge in tool.edges[before:] if not edge.level]
    assert [line for line, _ in offs] == [actuators[name].line for name in ("fingers", "right", "left")]
    assert [at for _, at in offs] == pytest.approx([0.0, fingers.release_s, fingers.release_s + 2], abs=0.1)
