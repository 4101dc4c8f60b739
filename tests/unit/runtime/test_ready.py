"""When a tool is ready: nothing that its sensors show has the next command refused."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import pytest

from end_effector_hal.description import Description, load, profile_path
from end_effector_hal.runtime.tool._ready import is_ready, missing
from end_effector_hal.vocabulary import EndEffectorState, Evidence
from end_effector_hal.wires.sensors import SensorHealth
from tests.support.virtual_tool import VirtualTool

GONE, PARTIAL, CONFIRMED, UNKNOWN = Evidence.GONE, Evidence.PARTIAL, Evidence.CONFIRMED, Evidence.UNKNOWN
STAND_BY, GRIP_ERROR, OFF = EndEffectorState.STAND_BY, EndEffectorState.GRIP_ERROR, EndEffectorState.OFF


@pytest.fixture(scope="module")
def tool() -> VirtualTool:
    tool = VirtualTool(load(profile_path()))
    tool.run(1.0)
    return tool


@pytest.mark.parametrize(
    ("state", "evidence", "ready"),
    [
        (STAND_BY, (GONE, GONE, GONE), True),
        (STAND_BY, (GONE, PARTIAL, GONE), False),
        (STAND_BY, (GONE, GONE, CONFIRMED), False),
        (STAND_BY, (GONE, UNKNOWN, GONE), False),
        (GRIP_ERROR, (CONFIRMED, PARTIAL, GONE), True),  # a Drop is accepted
        (GRIP_ERROR, (CONFIRMED, UNKNOWN, GONE), False),
        (OFF, (GONE, GONE, GONE), False),
    ],
)
def test_by_state_and_evidence(
    tool: VirtualTool, state: EndEffectorState, evidence: Sequence[Evidence], ready: bool
) -> None:
    status = replace(tool.status, ee=state, evidence=tuple(evidence))
    assert is_ready(tool.description, status) is ready
    assert not is_ready(tool.description, replace(status, link_up=False))


def test_without_il_07_feedback_is_not_in_the_way(tool: VirtualTool) -> None:
    locks = tool.description.interlocks.model_copy(update={"il_07": False})
    free: Description = tool.description.model_copy(update={"interlocks": locks})
    assert is_ready(free, replace(tool.status, evidence=(GONE, PARTIAL, GONE)))


def test_what_is_in_the_way_is_named(tool: VirtualTool) -> None:
    status = replace(tool.status, evidence=(PARTIAL, GONE, CONFIRMED))
    told = list(missing(tool.description, status, SensorHealth({}, None)))
    assert told == [
        "a grip would be refused, since Bottom vacuum, Top vacuum are not proven to be gone "
        "(IL-07): a Drop releases once more"
    ]


def test_a_tool_that_is_ready_grips_also_after_the_link_was_silent(tool: VirtualTool) -> None:
    """In every instant after the frames are back: ready means that the automata accept a grip."""
    played = VirtualTool(tool.description)
    played.run(1.0)
    assert played.command("lock").accepted
    played.run(1.0)
    played.link = False
    played.run(0.4)
    played.link = True
    seen = set()
    for _ in range(40):
        played.run(0.01)
        ready = is_ready(played.description, played.status)
        if ready:
            assert played.controller.refusal("grip") == ""
        elif Evidence.UNKNOWN not in played.status.evidence:
            assert played.controller.refusal("grip").startswith("IL-07")
            seen.add("partial")
        seen.add(ready)
    assert seen == {False, "partial", True}
