"""Lines in the panels of mm, % and V: what conditions compare them with."""

from dataclasses import replace
from math import inf, nan

import pytest

from end_effector_hal.description import examine_text
from end_effector_hal.recording import PressuresLog, RunInfo, read_run, run_info
from end_effector_lab.figures import timeline
from end_effector_lab.figures._style import BAND_INK
from tests.support.trace_recordings import log
from tests.unit.figures.figure_facts import overlaps, texts

TOOL = """\
name: pusher
link: {port: /dev/a, frame: {text: {start: "$"}}}
channels:
  gap: {text: {field: 1, decimals: 2}, unit: mm, range: [0, 60]}
  rear: {text: {field: 2, decimals: 2}, unit: mm}
  fill: {text: {field: 3}, unit: "%"}
  cup: {text: {field: 4}, unit: kPa}
sequence: [jaw]
actuators:
  jaw:
    kind: gripper
    line: A
    evidence:
      confirmed: {all: [{channel: gap, between: [12.25, 14]}, {channel: fill, above: 40}, {channel: cup, above_kpa: 5}]}
      gone: {all: [{channel: gap, above: 50}, {not: {channel: rear, below: 48}}]}
      empty: {channel: gap, below: 2}
      fault: {channel: fill, above: 99}
supply: {channel: none}
"""
ROWS = log((0.0, 6, -1, 0), (1.0, 1, 2, 1), (2.0, 3, -1, 2), (8.0, 6, -1, 0), names=("jaw",))


def measured(units, *rows):
    return PressuresLog(tuple(units), tuple(rows), units=units)


@pytest.fixture(scope="module")
def info():
    examined = examine_text(TOOL, "tool.yaml")
    assert examined.description, examined.faults
    return run_info(examined.description)


def test_a_recording_says_them_of_what_is_no_pressure(info, tmp_path):
    keys = ("channel", "proves", "sign", "at")
    listed = [tuple(each[key] for key in keys) for each in info.limits["jaw"]["measured"]]
    assert listed == [
        ("gap", "confirmed", "≥", 12.25), ("gap", "confirmed", "≤", 14.0), ("fill", "confirmed", ">", 40.0),
        ("gap", "gone", ">", 50.0), ("rear", "gone", "≥", 48.0), ("gap", "empty", "<", 2.0),
        ("fill", "fault", ">", 99.0),
    ]  # fmt: skip
    info.write(tmp_path)
    assert read_run(tmp_path) == info


def test_each_is_a_line_with_its_words_in_the_panel_of_its_unit(info):
    curves = measured(
        {"gap": "mm", "fill": "%"}, (0.0, (55.0, 20.0)), (2.0, (13.0, 60.0)), (8.0, (55.0, 20.0))
    )
    figure = timeline(ROWS, curves, info)
    shown = set(texts(figure))
    assert {"confirmed ≥ 12.25", "confirmed ≤ 14", "gone > 50", "empty < 2", "confirmed > 40"} <= shown
    _, gap, fill = figure.axes
    lines = [
        (line.get_label(), line.get_ydata()[0])
        for line in gap.get_lines()
        if line.get_label() in ("gone", "empty")
    ]
    assert sorted(lines) == [("empty", 2.0), ("gone", 50.0)]
    (confirmed,) = [line for line in fill.get_lines() if line.get_label() == "confirmed"]
    assert (confirmed.get_ydata()[0], confirmed.get_color()) == (40.0, BAND_INK)
    assert not any("99" in each or "fault" in each for each in shown)
    assert overlaps(figure) == []


def test_of_several_curves_it_says_whose(info):
    figure = timeline(
        ROWS, measured({"gap": "mm", "rear": "mm"}, (0.0, (55.0, 55.0)), (8.0, (13.0, 50.0))), info
    )
    assert {"Gap\ngone > 50", "Rear\ngone ≥ 48"} <= set(texts(figure))
    assert overlaps(figure) == []


def test_the_line_of_a_number_that_was_never_reached_is_shown(info):
    figure = timeline(ROWS, measured({"fill": "%"}, (0.0, (1.0,)), (8.0, (2.0,))), info)
    low, high = figure.axes[1].get_ylim()
    assert low < 40 < high


@pytest.mark.parametrize(
    "wrong",
    [
        3, [3], [{}], [{"channel": "fill", "proves": [], "sign": ">", "at": 1}],
        [{"channel": "fill", "proves": "lost", "sign": "!", "at": 1}],
        *([{"channel": "fill", "proves": "lost", "sign": ">", "at": at}] for at in ("1", None, nan, inf, 10**400)),
    ],
)  # fmt: skip
def test_what_is_no_threshold_is_not_drawn(wrong):
    info = replace(RunInfo(), limits={"jaw": {"measured": wrong}})
    figure = timeline(ROWS, measured({"fill": "%"}, (0.0, (1.0,)), (8.0, (2.0,))), info)
    assert not [line for line in figure.axes[1].get_lines() if line.get_label() == "lost"]
