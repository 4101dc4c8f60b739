"""The lane of the e-stop, and how far the lanes of switches reach."""

from dataclasses import replace

from end_effector_hal.recording import AlarmRow, SwitchesLog
from end_effector_lab.figures import timeline
from end_effector_lab.figures._style import FILLS
from tests.support.trace_recordings import INFO, NOMINAL
from tests.unit.figures.figure_facts import bars, overlaps, texts

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
