"""A status says the same whenever it is read: at once, or after the lines were written."""

from __future__ import annotations

import pickle

import pytest

from end_effector_hal.control import Status
from end_effector_hal.description import load, profile_path
from tests.support.virtual_tool import VirtualTool

DESCRIPTION = load(profile_path())
FIRST = ("at", "ee", "outputs", "held", "kept", "blowing", "dropped", "unlock_output", "adopted")
"""What decides about the lines, and is known before the rest is worked out."""


class Reads(VirtualTool):
    """Reads each status at once."""

    def _told(self, statuses: list[Status]) -> None:
        assert pickle.loads(pickle.dumps(statuses)) == statuses
        super()._told(statuses)


def play(tool: VirtualTool) -> VirtualTool:
    tool.run(1.0)
    tool.command("grip")
    tool.run(6.0)
    tool.link = False
    tool.run(1.5)
    tool.link = True
    tool.run(2.0)
    tool.command("drop")
    tool.run(3.0)
    return tool


@pytest.mark.parametrize(
    "scenario", ["fails-once:cylinder", "leak:bottom_vacuum", "never-confirms:top_vacuum"]
)
def test_a_status_that_is_read_later_says_the_same(scenario: str) -> None:
    later, at_once = play(VirtualTool(DESCRIPTION, scenario)), play(Reads(DESCRIPTION, scenario))
    assert len(later.statuses) > 20
    assert later.statuses == at_once.statuses


def test_what_decides_about_the_lines_is_known_before_the_rest() -> None:
    tool = VirtualTool(DESCRIPTION)
    tool.run(1.0)
    _, statuses = tool.controller.command("grip", tool.at)
    draft, alarms = statuses[-1], Status.alarms.__get__  # type: ignore[attr-defined]
    assert all(hasattr(draft, name) for name in FIRST)
    with pytest.raises(AttributeError):
        alarms(draft)  # nobody has asked for it yet
    assert draft.alarms == alarms(draft) == ()
    with pytest.raises(AttributeError):
        draft.nonsense  # type: ignore[attr-defined]  # noqa: B018
