"""Lines in the panels of mm, % and V: what conditions compare them with."""

from dataclasses import replace
from math import inf, nan

import pytest

from end_effector_hal.description import examine_text
from end_effector_hal.recording import (
    AlarmRow,
    PressuresLog,
    RunInfo,
    SwitchesLog,
    read_run,
    run_info,
)
from end_effector_lab.figures import timeline
from end_effector_lab.figures._style import BAND_INK, FILLS
from tests.support.trace_recordings import INFO, NOMINAL, log
from tests.unit.figures.figure_facts import bars, overlaps, texts

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


PROVES = {"top_cup": {"actuator": "top_vacuum", "on": "confirmed", "off": "gone"}}
LAST_S = NOMINAL.rows[-1].time_s


def drawn(info, *rows):
    return timeline(NOMINAL, None, info, switches=SwitchesLog(("top_cup", "stop_ok"), rows))


def step(figure, lane):
    (line,) = [each for each in figure.axes[0].get_lines() if each.get_label() == f"{lane}: level"]
    return line.get_ydata()


def red(colour):
    return tuple(round(part * 255) for part in colour[:3]) == tuple(bytes.fromhex(FILLS["error"][1:]))


def test_it_is_up_while_closed_red_while_open_and_has_a_gap_where_nothing_valid_was_read():
    rows = ((0.0, (False, True)), (2.0, (False, False)), (5.0, (False, None)), (8.0, (False, True)))
    figure = drawn(replace(INFO, switches=PROVES, e_stop="stop_ok"), *rows)
    shown = bars(figure, "e-stop")
    assert [(word, round(start, 3)) for word, start, *_ in shown] == [
        ("closed", 0.0), ("open", 2.0), ("not known", 5.0), ("closed", 8.0)
    ]  # fmt: skip
    assert [red(colour) for *_, colour in shown] == [False, True, False, False]
    closed, _, opened, _, unknown, *_ = step(figure, "e-stop")
    assert closed < opened, "inches run downwards"
    assert unknown != unknown
    assert {"E-stop", "closed", "open", "not known"} <= set(texts(figure))
    assert overlaps(figure) == []


def test_it_stands_below_the_switches_and_alone_it_says_what_its_line_is():
    rows = ((0.0, (False, True)),)
    both = drawn(replace(INFO, switches=PROVES, e_stop="stop_ok"), *rows)
    assert texts(both).index("Top cup") < texts(both).index("E-stop")
    assert min(step(both, "e-stop")) > max(step(both, "switch top_cup"))
    caption = "the line is the level: up while the e-stop is closed"
    assert caption not in texts(both)
    alone = drawn(replace(INFO, e_stop="stop_ok"), *rows)
    assert caption in texts(alone)
    assert overlaps(alone) == []


def test_a_tool_without_one_has_no_lane():
    rows = ((0.0, (False, True)), (2.0, (False, False)))
    assert "E-stop" not in texts(drawn(replace(INFO, switches=PROVES), *rows))
    assert not bars(drawn(INFO, *rows), "e-stop")
    elsewhere = drawn(replace(INFO, e_stop="of_another_recording"), *rows)
    assert not bars(elsewhere, "e-stop")


def test_a_short_opening_is_as_wide_as_a_short_error():
    figure = drawn(
        replace(INFO, e_stop="stop_ok"), (0.0, (None, True)), (2.0, (None, False)), (2.01, (None, True))
    )
    ((_, start, end, _),) = [bar for bar in bars(figure, "e-stop") if bar[0] == "open"]
    assert start < 2.0
    assert end > 2.01


def test_an_e_stop_that_opens_after_the_last_change_of_the_states_is_shown_with_its_alarm():
    """It changes no state: what is held stays held."""
    opened_s = LAST_S + 2
    switches = SwitchesLog(("stop_ok",), ((0.0, (True,)), (opened_s, (False,))))
    alarms = [AlarmRow(opened_s + 0.05, "begun", "IL-13: the emergency stop was opened.")]
    figure = timeline(NOMINAL, None, replace(INFO, e_stop="stop_ok"), alarms, switches=switches)
    _, right = figure.axes[0].get_xlim()
    assert opened_s + 0.05 < right
    ((_, start, end, _),) = [bar for bar in bars(figure, "e-stop") if bar[0] == "open"]
    assert (start, round(end, 6)) == (opened_s, round(right, 6))
    assert {"IL-13", "GRIP", "DROP"} <= set(texts(figure, "event"))
    assert overlaps(figure) == []


def test_no_lane_passes_the_end_of_a_figure_that_is_long_enough():
    rows = ((0.0, (False, True)), (2.0, (True, True)), (100 * LAST_S, (False, False)))
    figure = drawn(replace(INFO, switches=PROVES, e_stop="stop_ok"), *rows)
    _, right = figure.axes[0].get_xlim()
    assert right < 2 * LAST_S
    for lane in ("switch top_cup", "e-stop"):
        assert max(end for _, _, end, _ in bars(figure, lane)) <= right
    assert not [bar for bar in bars(figure, "e-stop") if bar[0] == "open"]


def test_a_switch_without_a_lane_makes_no_figure_longer():
    short = drawn(replace(INFO, switches=PROVES), (0.0, (False, True)))
    same = drawn(replace(INFO, switches=PROVES), (0.0, (False, True)), (LAST_S + 2, (False, False)))
    assert short.axes[0].get_xlim() == same.axes[0].get_xlim()
