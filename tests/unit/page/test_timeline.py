"""Lanes of switches, and pressures that come over several links."""

from pathlib import Path

import pytest

from end_effector_hal.codecs import load_tool
from end_effector_hal.kinds import SwitchMeaning
from end_effector_hal.page.view import Curve
from end_effector_hal.page.view._timeline import FRESH_US, TimeLine

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
