"""What is measured, whatever it is: gauges with the marks of their thresholds, curves in their unit."""

from __future__ import annotations

import pytest

from end_effector_hal.codecs import carrier_of
from end_effector_hal.description import Description, examine_text
from end_effector_hal.page.view import Cards
from end_effector_hal.page.view._curves import curves_of
from end_effector_hal.page.view._timeline import TimeLine

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
    assert gap.marks == (("gone", 50.0), ("empty", 2.0), ("confirmed", 12.25), ("confirmed", 14.0))
    assert (force.unit, force.low, force.marks) == ("N", 0.0, (("confirmed", 40.0),))
    assert force.most == pytest.approx(56.0)
    cup, rear = curves["cup"]
    assert (cup.name, cup.unit, cup.own, cup.marks) == (
        "cup",
        "kPa below ambient",
        True,
        (("gone", 10.0), ("confirmed", 55.0)),
    )
    assert (rear.unit, rear.marks, rear.most) == ("kPa", (("confirmed", -40.0),), 0.0)
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
