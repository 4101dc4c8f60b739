"""A device that sends and says that its reading is invalid is no dead link; what it proves is unknown all the same."""

from __future__ import annotations

import pytest

from end_effector_hal.description import examine_text
from end_effector_hal.signals import Frame, Value
from end_effector_hal.vocabulary import Evidence
from tests.support.virtual_tool import VirtualTool

TOOL = """\
name: cup
link: {{port: /dev/a, frame: {{text: {{}}}}}}
channels:
  cup: {{text: {{field: 1}}, unit: kPa, invalid: [-9999]}}
  {also}
sequence: [cup]
actuators: {{cup: {{kind: vacuum, line: A, channel: cup}}}}
supply: {{channel: none}}
"""
SAYS = "frames come, and say that the value is invalid or beyond its range"
ALSO = {"alone": "", "board": "door: {digital: {line: X}}"}
S, MS = 1_000_000, 1_000


def tool_that(also: str, *, held: bool = False) -> VirtualTool:
    description = examine_text(TOOL.format(also=ALSO[also]), "tool.yaml").description
    assert description
    tool = VirtualTool(description)
    tool.link = False  # what comes is what `feed` gives
    feed(tool, 2.0, also, -10)
    if held:
        assert tool.command("grip").accepted
        feed(tool, 1.0, also, -80_000)
        assert tool.status.held
    return tool


def feed(tool: VirtualTool, seconds: float, also: str, value: Value = None, *, link: bool = True) -> None:
    for _ in range(round(seconds * 50)):
        tool.run(0.02)
        if link:
            tool.controller.frame(Frame(tool.at, None, None, {"cup": value}), tool.at)
        if also == "board":
            tool.controller.frame(Frame(tool.at, None, None, {"door": False}), tool.at)


@pytest.mark.parametrize("also", ALSO)
def test_the_link_is_up_and_the_alarm_names_the_reading(also: str) -> None:
    tool = tool_that(also)
    feed(tool, 3.0, also)
    status = tool.status
    assert (status.link_up, status.stale, status.evidence) == (True, ("cup",), (Evidence.UNKNOWN,))
    assert status.alarm_texts == (f"No valid reading of cup: {SAYS}.",)
    assert not tool.command("grip").accepted


@pytest.mark.parametrize("also", ALSO)
def test_a_link_that_then_falls_silent_is_down(also: str) -> None:
    tool = tool_that(also)
    feed(tool, 3.0, also)
    feed(tool, 2.0, also, link=False)
    status = tool.status
    assert not status.link_up
    assert [each.endswith("down.") for each in status.alarm_texts] == [True]


@pytest.mark.parametrize("also", ALSO)
def test_what_is_held_is_held_and_the_alarm_says_that_the_device_sends(also: str) -> None:
    tool = tool_that(also, held=True)
    edges = tool.edges.copy()
    feed(tool, 3.0, also)
    status = tool.status
    assert (status.held, status.evidence, tool.edges) == (True, (Evidence.UNKNOWN,), edges)
    assert f"No valid reading of Cup while it holds a part ({SAYS}); active outputs" in status.alarm_texts[0]


def test_a_sensor_that_is_doubted_is_told_in_the_words_of_the_doubt_only() -> None:
    tool = tool_that("alone")
    feed(tool, 3.0, "alone", 900_000)  # no vacuum has such a pressure
    alarms = " ".join(tool.status.alarm_texts)
    assert "it counts as invalid" in alarms
    assert SAYS not in alarms
