"""A time-out that the machine takes late is taken late, counted, and told when it exceeds the reaction bound."""

from __future__ import annotations

import pytest

from end_effector_hal.control import Status
from end_effector_hal.description import load, profile_path
from end_effector_hal.signals import Frame
from tests.support.virtual_tool import VirtualTool

DUE = 6_000_000


@pytest.fixture
def tool() -> VirtualTool:
    """Shortly before the first time-out of the first step."""
    tool = VirtualTool(load(profile_path()), "never-confirms:bottom_vacuum")
    tool.run(1.0)
    tool.command("grip")
    tool.run(4.9)
    assert tool.status.deadline == DUE
    return tool


def confirm(tool: VirtualTool, stamp: int, at: int) -> list[Status]:
    """The third confirming frame comes at ``stamp`` and is taken at ``at``."""
    gripped = {**tool.bench.sample(tool.at), "bottom": -60_000}
    for earlier in (DUE - 40_000, DUE - 20_000):
        tool.controller.frame(Frame(earlier, None, None, gripped), earlier)
    return tool.controller.frame(Frame(stamp, None, None, gripped), at)


@pytest.mark.parametrize(("late_us", "missed"), [(0, 0), (50_000, 0), (50_001, 1)])
def test_a_late_time_out(tool: VirtualTool, late_us: int, missed: int) -> None:
    tool.controller.advance(DUE - 1)
    assert tool.status.outputs[0]
    statuses = tool.controller.advance(DUE + late_us)
    assert not statuses[-1].outputs[0]
    assert statuses[-1].at == DUE + late_us
    assert tool.status.worst_late_us == late_us
    assert tool.status.missed == missed
    assert tool.status.deadline == DUE + late_us + 1_000_000  # the reset lasts its second all the same


def test_what_came_before_a_time_out_is_before_it_however_late_it_is_taken(tool: VirtualTool) -> None:
    last = confirm(tool, DUE, DUE + 30_000)[-1]
    assert [step.attempts for step in last.steps] == [1, 1, 0]
    assert last.outputs == (True, True, False)
    assert last.at == DUE + 30_000
    assert tool.status.deadline == DUE + 30_000 + 5_000_000


def test_what_came_after_a_time_out_is_after_it(tool: VirtualTool) -> None:
    assert confirm(tool, DUE + 1, DUE + 30_000)[-1].outputs == (False, False, False)
