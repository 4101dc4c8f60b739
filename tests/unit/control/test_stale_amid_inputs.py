"""A reading that turns stale in the instant of something else proves nothing from then on, whatever comes first."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from end_effector_hal.control import Controller, Status, network_of
from end_effector_hal.description import Description, examine_text
from end_effector_hal.signals import Frame
from end_effector_hal.vocabulary import Evidence
from tests.unit.sensing.test_several_links import MS, TOOL

STALE_US = 150 * MS


@pytest.fixture(scope="module")
def description() -> Description:
    found = examine_text(TOOL, "tool.yaml").description
    assert found is not None
    return found


class Tool:
    """Its controller, at rest with readings of both links; the one of the first link is the last one of it."""

    def __init__(self, description: Description) -> None:
        self.controller = Controller(description, network_of(description))
        self.controller.start({"A": False, "B": False}, 0)
        for number in range(1, 40):
            for channel in ("one", "two"):
                self.last = number * 20 * MS
                self.controller.frame(Frame(self.last, None, None, {channel: -100 - number}))
        assert self.status.evidence == (Evidence.GONE, Evidence.GONE)

    @property
    def status(self) -> Status:
        return self.controller.status()


INPUTS: dict[str, Callable[[Controller, int], list[Status]]] = {
    "a refusal": lambda controller, at: controller.refused(at),
    "a command": lambda controller, at: controller.command("cancel", at)[1],
    "an acknowledgement": lambda controller, at: controller.acknowledge(at),
}


@pytest.mark.parametrize("name", INPUTS)
def test_an_input_at_the_microsecond_in_which_a_reading_turns_stale(
    description: Description, name: str
) -> None:
    tool = Tool(description)
    stale_at = tool.last + STALE_US
    assert tool.controller.deadline == stale_at
    told = INPUTS[name](tool.controller, stale_at)
    assert told[-1].evidence[0] is Evidence.UNKNOWN
    again = INPUTS[name](tool.controller, stale_at)
    assert [status for status in again if name != "an acknowledgement"] == [], "it is told once"


def test_a_frame_that_came_before_and_is_taken_after(description: Description) -> None:
    tool = Tool(description)
    stale_at = tool.last + STALE_US
    for before in range(20 * MS, STALE_US, 20 * MS):
        tool.controller.frame(Frame(tool.last + before, None, None, {"two": -200 - before // MS}))
    frame = Frame(stale_at - 1 * MS, None, None, {"two": -100})
    told = tool.controller.frame(frame, stale_at + 2 * MS)
    assert told[-1].evidence == (Evidence.UNKNOWN, Evidence.GONE)
    assert told[-1].at == stale_at + 2 * MS
