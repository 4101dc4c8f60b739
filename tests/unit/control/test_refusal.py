"""What a controller says that it would refuse is what it does refuse, word for word, and asking changes nothing."""

from __future__ import annotations

import pytest

from end_effector_hal.control import COMMANDS, Controller, network_of
from end_effector_hal.description import Description
from tests.support.nightly import first_of
from tests.support.virtual_tool import VirtualTool


@pytest.mark.parametrize(
    "scenario",
    first_of(
        [
            "nominal",
            "lost-after:top_vacuum:3",
            "silent-after:4",
            "never-confirms:cylinder",
            "not-in-stand",
            "supply:300",
        ],
        2,
        2,
    ),
)
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
