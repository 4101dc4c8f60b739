"""Grip on a transport and a tool of the test: what its services ask of the tool."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest

from end_effector_hal.control import Answer
from end_effector_hal.nodes._services import GripNode
from tests.support.lone_node import LoneTransport


def test_each_service_asks_the_tool_and_passes_its_answer_on(caplog: pytest.LogCaptureFixture) -> None:
    transport = LoneTransport()
    GripNode(cast("Any", transport))
    refused = transport.hal.answer = Answer(False, "IL-12: a grip runs.")
    with caplog.at_level("INFO"):
        answers = [
            transport.services["SetBottomVacuum"](SimpleNamespace(data=True)),
            transport.services["SetCylinder"](SimpleNamespace(data=False)),
            transport.services["ResumeGrip"](None),
            transport.services["StopTool"](None),
            transport.services["ResetFaults"](None),
        ]
    assert answers == [refused] * 5
    assert transport.hal.asked == [("bottom_vacuum", True), ("cylinder", False), "resume", "stop", "reset"]
    assert [each.getMessage() for each in caplog.records] == [
        f"refused: {what}. IL-12: a grip runs."
        for what in ("bottom_vacuum on", "cylinder off", "resume", "stop", "reset")
    ]
