"""What is measured, whatever it is: gauges with the marks of their thresholds, curves in their unit."""

from __future__ import annotations

from pathlib import Path

import pytest

from end_effector_hal.codecs import carrier_of, load_tool
from end_effector_hal.description import Description, examine_text
from end_effector_hal.kinds import SwitchMeaning
from end_effector_hal.page.view import Cards, Curve
from end_effector_hal.page.view._curves import curves_of
from end_effector_hal.page.view._timeline import FRESH_US, TimeLine

TOOL = """\
name: pusher
link: {port: /dev/a, frame: {text: {start: "$"}}}
channels:
  gap: {text: {field: 1, decimals: 2}, unit: mm, range: [0, 60]}
  force: {text: {field: 2, decimals: 1}, unit: N}
  cup: {text: {field: 3}, unit: kPa}
  rear: {text: {field: 4}, unit: kPa}
sequence: [jaw, cup]
actuators:
  jaw:
    kind: gripper
    line: A
    evidence:
      confirmed: {all: [{channel: gap, between: [12.25, 14], for_ms: 60}, {channel: force, above: 40}]}
      gone: {channel: gap, above: 50, for_ms: 60}
      empty: {channel: gap, below: 2, for_ms: 60}
  cup:
    kind: vacuum
    line: B
    channel: cup
    evidence:
      confirmed: {all: [{channel: cup, below_kpa: -55}, {channel: rear, below_kpa: -40}]}
      gone: {channel: cup, above_kpa: -10}
supply: {channel: none}
"""


@pytest.fixture(scope="module")
def tool() -> Description:
    examined = examine_text(TOOL, "tool.yaml")
    assert examined.description, examined.faults
    return examined.description


def test_a_gauge_has_the_unit_the_range_and_the_thresholds_of_its_channel(tool: Description) -> None:
    curves = curves_of(tool, carrier_of(tool).channels)
    gap, force = curves["jaw"]
    assert (gap.unit, gap.low, gap.most, gap.decimals, gap.own) == ("mm", 0.0, 60.0, 2, False)
    assert gap.marks[""] == (("gone", 50.0), ("empty", 2.0), ("confirmed", 12.25), ("confirmed", 14.0))
    assert (force.unit, force.low, force.marks[""]) == ("N", 0.0, (("confirmed", 40.0),))
    assert force.most == pytest.approx(56.0)
    cup, rear = curves["cup"]
    assert (cup.name, cup.unit, cup.own, cup.marks[""]) == (
        "cup",
        "kPa below ambient",
        True,
        (("gone", 10.0), ("confirmed", 55.0)),
    )
    assert (rear.unit, rear.marks[""], rear.most) == ("kPa", (("confirmed", -40.0),), 0.0)
    assert rear.low == pytest.approx(-56.0)


def test_values_are_in_the_units_of_their_gauges(tool: Description) -> None:
    cards = Cards(tool, dict(carrier_of(tool).channels))
    readings = {"gap": 12_500, "force": None, "cup": -60_000, "rear": -41_000}
    assert cards.values("jaw", readings) == [12.5, None]
    assert cards.values("cup", readings) == [60.0, -41.0]
    assert [curve.channel for curve in cards.curves] == ["gap", "force", "cup", "rear"]
    line = TimeLine(tool, cards.curves, {})
    line.frame(7, readings)
    assert line.since(0, 0)["samples"] == [[7, 12.5, None, 60.0, -41.0]]


JAW = load_tool(Path("examples/tools/double_acting_jaw/end_effector.yaml"))


@pytest.fixture
def line() -> TimeLine:
    curves = [
        Curve("cup", "vacuum", "Cup", "kPa below ambient", below=True),
        Curve("rod", "air", "Rod", "kPa"),
    ]
    return TimeLine(JAW, curves, {"jaw_open": SwitchMeaning("gone", "")})


def test_a_switch_is_a_lane_with_its_level_and_what_it_proves(line: TimeLine) -> None:
    for at, level in ((0, True), (1, True), (2, False), (3, None)):
        line.frame(at, {"jaw_open": level, "other": True})
    line.frame(4, {"vacuum": -50_000})  # another link: the switch is as it was
    line.frame(5, {"jaw_open": True})
    line.gap(6)
    changes = [(each["at"], each["word"]) for each in line.since(0, 0)["changes"]]
    assert changes == [(0, "on: gone"), (2, "off"), (3, ""), (5, "on: gone"), (6, "")]
    assert line.lanes[-1] == {"name": "switch jaw_open", "label": "Jaw open"}


def test_a_pressure_goes_on_between_the_frames_of_its_link_and_ends_with_it(line: TimeLine) -> None:
    line.frame(0, {"vacuum": -50_000, "air": 600_000})
    line.frame(10, {"air": 500_000})
    line.frame(20, {"vacuum": None})
    line.frame(30, {"vacuum": -40_000})
    line.frame(30 + FRESH_US, {"vacuum": -40_000})
    assert line.since(0, 0)["samples"] == [
        [0, 50.0, 600.0], [10, 50.0, 500.0], [20, None, 500.0], [30, 40.0, 500.0], [30 + FRESH_US, 40.0, None],
    ]  # fmt: skip
