"""The default figure: asserted from the figure, not from pixels."""

import subprocess
import sys
from dataclasses import replace

import pytest
from hypothesis import given, settings

from end_effector_hal.errors import UsageError
from end_effector_hal.recording import (
    AlarmRow,
    ChangerRow,
    PressuresLog,
    RunInfo,
    StatesLog,
    SwitchesLog,
    Watched,
)
from end_effector_hal.vocabulary import ChangerState
from end_effector_lab.figures import save, timeline
from tests.support.nightly import examples, first_of
from tests.support.trace_recordings import (
    CANCELLED,
    FAILS_ONCE,
    INFO,
    NAMES,
    NEVER,
    NOMINAL,
    PRESSURES,
    log,
    moved,
)
from tests.unit.figures.figure_facts import bars, overlaps, recordings, texts

SCENARIOS = {"nominal": NOMINAL, "fails-once": FAILS_ONCE, "never": NEVER, "cancelled": CANCELLED}


def long_recording(grips, pause_s=30.0):
    rows, events, start = (), (), 0.0
    for number in range(grips):
        source = moved((NOMINAL, FAILS_ONCE, NEVER)[number % 3], lambda at, start=start: start + at)
        rows, events = rows + source.rows, events + source.events
        start = rows[-1].time_s + pause_s
    return replace(NOMINAL, rows=rows, events=events)


def test_the_title_is_the_verdict_and_the_subtitle_the_source():
    shown = texts(timeline(NEVER, PRESSURES, INFO))
    assert "Cylinder never confirmed: grip ABORTED after 3 attempts, released in reverse order" in shown
    assert (
        "scenario never-confirms:cylinder  ·  description verdin_gripper 3f9c1a2b  ·  end-effector-hal 0.1.0"
        "  ·  ROS  ·  2026-03-04 10:20  ·  simulated"
    ) in shown
    assert {"inactive", "waiting for sensor", "confirmed", "releasing", "error", "command"} <= set(shown)


@pytest.mark.parametrize(
    ("info", "shown"),
    [
        (RunInfo(), "no run.json: source unknown"),
        (RunInfo(description="x"), "description x  ·  without ROS  ·  not simulated"),
        (RunInfo(scenario="nominal", simulated=False), "scenario nominal  ·  without ROS  ·  not simulated"),
    ],
)
def test_what_is_not_known_is_not_claimed(info, shown):
    assert shown in texts(timeline(NOMINAL, info=info))


def test_lanes_have_the_times_of_the_recording():
    figure = timeline(NEVER)
    cylinder = [(state, round(start, 6), round(end, 6)) for state, start, end, _ in bars(figure, "cylinder")]
    assert cylinder[:6] == [
        ("RETRACTED", 0.0, 1.5),
        ("PENDING EXTEND", 1.5, 6.5),
        ("RETRACTED", 6.5, 7.5),
        ("PENDING EXTEND", 7.5, 12.5),
        ("RETRACTED", 12.5, 13.5),
        ("PENDING EXTEND", 13.5, 18.5),
    ]
    assert [state for state, *_ in bars(figure, "top_vacuum")] == ["OFF"]
    assert [state for state, *_ in bars(figure, "command")] == ["NONE", "GRIP", "RELEASE", "NONE"]
    assert {"End-effector", "Command", "Bottom vacuum", "Cylinder", "Top vacuum", "Events"} <= set(
        texts(figure)
    )


def test_an_error_of_no_length_is_a_red_mark_with_its_name():
    figure = timeline(NEVER)
    ((_, start, end, colour),) = [bar for bar in bars(figure, "end_effector") if bar[0] == "GRIP_ERROR"]
    assert start < 18.5 < end
    assert 0.04 < end - start < 0.3
    assert colour[0] > 0.6
    assert max(colour[1:3]) < 0.3
    assert "GRIP_ERROR" in texts(figure, "beside")


def test_names_stand_inside_where_they_fit_and_beside_where_they_do_not():
    figure = timeline(NEVER)
    assert texts(figure, "inside").count("PENDING EXTEND") == 3
    assert "GRIPPING" in texts(figure, "inside")
    assert {"PENDING ON", "RELEASING"} <= set(texts(figure, "beside"))


def test_the_events():
    assert texts(timeline(NEVER, info=INFO), "event") == [
        "GRIP",
        "Cylinder time-out 1/3",
        "Cylinder time-out 2/3",
        "Cylinder time-out 3/3 – abort",
    ]
    assert texts(timeline(FAILS_ONCE, info=INFO), "event") == [
        "GRIP",
        "Cylinder time-out 1/3",
        "GRIPPED",
        "DROP",
    ]
    assert texts(timeline(CANCELLED), "event") == ["GRIP", "CANCEL"]


def test_pressures_with_their_accepted_ranges():
    figure = timeline(NEVER, PRESSURES, INFO)
    shown = texts(figure)
    assert {
        "vacuum\n[gauge kPa]",
        "pressure\n[gauge kPa]",
        "confirmed ≤ −55",
        "confirmed ≥ 510",
        "Supply",
    } <= set(shown)
    vacuum, above = figure.axes[1:]
    assert {line.get_label() for line in vacuum.lines} >= {"Bottom vacuum", "Top vacuum"}
    assert {line.get_label() for line in above.lines} >= {"Cylinder", "Supply"}
    (band,) = vacuum.patches
    assert (band.get_y() + band.get_height(), band.get_y()) == (-55.0, vacuum.get_ylim()[0])
    (band,) = above.patches
    assert (band.get_y(), band.get_y() + band.get_height()) == (510.0, above.get_ylim()[1])


def test_a_curve_has_a_hole_where_nothing_valid_was_received():
    vacuum = timeline(NEVER, PRESSURES, INFO).axes[1]
    top = next(line for line in vacuum.lines if line.get_label() == "Top vacuum")
    # invalid at 1.0 s, nothing received between 2.0 s and 19.5 s
    assert [str(value) for value in top.get_ydata()] == ["0.0", "0.0", "nan", "0.0", "0.0", "nan", "0.0"]


def test_pressures_without_a_run_file_are_found_by_name_and_have_no_range():
    figure = timeline(NEVER, PRESSURES)
    assert not any("confirmed " in text for text in texts(figure))
    assert [line.get_label() for line in figure.axes[1].lines][1:3] == ["Bottom vacuum", "Top vacuum"]
    assert [len(axes.patches) for axes in figure.axes[1:]] == [0, 0]


def test_channels_without_a_value_have_no_panel():
    nothing = PressuresLog(("bottom", "cylinder"), ((0.0, (None, None)), (1.0, (None, None))))
    assert (
        len(timeline(NEVER, nothing, INFO).axes)
        == len(timeline(NEVER, PressuresLog(("bottom",), ())).axes)
        == 2
    )


@pytest.mark.parametrize("name", SCENARIOS)
@pytest.mark.parametrize("pressures", [None, PRESSURES])
def test_no_words_stand_on_each_other(name, pressures):
    assert overlaps(timeline(SCENARIOS[name], pressures, INFO)) == []


@pytest.mark.parametrize("factor", first_of([0.05, 30, 0.5, 5], 2, 0))
@pytest.mark.parametrize("name", SCENARIOS)
def test_short_and_long_recordings_are_readable(name, factor):
    figure = timeline(moved(SCENARIOS[name], lambda at: at * factor), None, INFO)
    assert overlaps(figure) == []
    assert len(texts(figure, "event")) == len(texts(timeline(SCENARIOS[name], None, INFO), "event"))


def test_ten_minutes_with_one_grip_in_the_middle():
    grip = moved(NEVER, lambda at: at + 300 if at else 0.0)
    end = log((600, 6, 0, 0, 0, 0), events=[(600, "lock")])
    long = replace(grip, rows=grip.rows + end.rows, events=grip.events + end.events)
    figure = timeline(long, None, INFO)
    assert overlaps(figure) == []
    assert texts(figure, "event") == [
        "GRIP",
        "Cylinder time-out 1/3",
        "Cylinder time-out 2/3",
        "Cylinder time-out 3/3 – abort",
        "LOCK",
    ]
    assert "GRIP_ERROR" in texts(figure, "beside")


@pytest.mark.thinned
def test_many_grips_keep_the_words_of_what_went_wrong():
    figure = timeline(long_recording(24), None, INFO)
    assert overlaps(figure) == []
    assert texts(figure, "event").count("abort") == 8
    assert "24 grips: 16 GRIPPED, 8 ABORTED (Cylinder never confirmed)" in texts(figure)


@pytest.mark.parametrize("number", [1, 2, 9])
def test_any_number_of_actuators(number):
    names = [f"actuator_{n}_with_a_rather_long_name_{n}" for n in range(number)]
    rows = [(float(n), 1, 2, *[2] * n, 1, *[0] * (number - n - 1)) for n in range(number)]
    figure = timeline(log((0, 6, -1, *[0] * number), *rows, (number, 3, -1, *[2] * number), names=names))
    assert overlaps(figure) == []
    assert len(bars(figure, names[-1])) == 3 if number > 1 else 2


def test_a_single_row_and_a_late_start_are_drawn():
    assert bars(timeline(log((0, 6, -1, 0, 0, 0))), "end_effector")[0][0] == "STAND_BY"
    figure = timeline(log((1000, 6, -1, 0, 0, 0), (1001, 1, 2, 1, 0, 0)))
    assert figure.axes[0].get_xlim()[0] == 1000


def test_a_recording_without_rows_is_refused():
    with pytest.raises(UsageError, match=r"empty\.csv: This recording holds no row"):
        timeline(StatesLog(NAMES, (), "empty.csv"))


def test_somebody_elses_text_cannot_spoil_the_figure(tmp_path):
    info = RunInfo(
        scenario="$x_{1$ 漢字 \x00\n<b>&" + "long" * 50, description="$$", hash="\ud800", version="$$"
    )
    figure = timeline(NOMINAL, None, info)
    assert overlaps(figure) == []
    save(figure, tmp_path / "a.svg")
    save(figure, tmp_path / "a.png")


def test_svg_is_text_and_the_same_every_time(tmp_path):
    for name in ("a.svg", "b.svg", "a.png", "b.png"):
        save(timeline(NEVER, PRESSURES, INFO), tmp_path / name)
    svg = (tmp_path / "a.svg").read_text()
    assert ">Cylinder time-out 3/3 – abort</text>" in svg
    assert "<dc:date>" not in svg
    assert svg == (tmp_path / "b.svg").read_text()
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    assert len(list(tmp_path.iterdir())) == 4


def test_what_cannot_be_saved_is_refused(tmp_path):
    figure = timeline(NOMINAL)
    with pytest.raises(UsageError, match=r"neither \.png nor \.svg"):
        save(figure, tmp_path / "a.pdf")
    with pytest.raises(UsageError, match="cannot be written: No such file or directory"):
        save(figure, tmp_path / "none" / "a.png")


def test_matplotlib_is_loaded_only_for_a_figure_and_never_pyplot():
    code = (
        "import sys; import end_effector_lab.figures as t; import end_effector_lab.commands._plot;"
        "assert {*t.__all__} <= {*dir(t)};"  # the documentation lists it
        "assert 'matplotlib' not in sys.modules;"
        "from end_effector_hal.recording import *; from end_effector_hal.vocabulary import *;"
        "t.timeline(StatesLog((), (StatesRow(0.0, EndEffectorState.OFF, Command.NONE, ()),)));"
        "assert 'matplotlib' in sys.modules and 'matplotlib.pyplot' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_the_kinds_of_state_are_told_apart_under_colour_blindness():
    from matplotlib.colors import to_rgb

    from end_effector_lab.figures._style import FILLS

    # Machado, Oliveira, Fernandes (2009), severity 1.0, on linear RGB
    views = {
        "normal": [(1, 0, 0), (0, 1, 0), (0, 0, 1)],
        "protanopia": [
            (0.152286, 1.052583, -0.204868),
            (0.114503, 0.786281, 0.099216),
            (-0.003882, -0.048116, 1.051998),
        ],
        "deuteranopia": [
            (0.367322, 0.860646, -0.227968),
            (0.280085, 0.672501, 0.047413),
            (-0.011820, 0.042940, 0.968881),
        ],
        "tritanopia": [
            (1.255528, -0.076749, -0.178779),
            (-0.078411, 0.930809, 0.147602),
            (0.004733, 0.691367, 0.303900),
        ],
    }
    for name, view in views.items():
        seen = {
            kind: _lab(
                [sum(w * v for w, v in zip(row, map(_linear, to_rgb(c)), strict=True)) for row in view]
            )
            for kind, c in FILLS.items()
        }
        for a in seen:
            for b in seen:
                distance = sum((x - y) ** 2 for x, y in zip(seen[a], seen[b], strict=True)) ** 0.5
                assert a == b or distance > 12, (name, a, b, distance)


def _linear(value):
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


def _lab(rgb):
    r, g, b = (min(max(value, 0.0), 1.0) for value in rgb)
    xyz = (
        (0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505,
        0.2126 * r + 0.7152 * g + 0.0722 * b,
        (0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089,
    )
    x, y, z = (v ** (1 / 3) if v > 0.008856 else 7.787 * v + 16 / 116 for v in xyz)
    return 116 * y - 16, 500 * (x - y), 200 * (y - z)


@settings(max_examples=examples(6, 200), deadline=None)
@given(recordings())
def test_any_recording_is_drawn_without_words_on_words(recording):
    assert overlaps(timeline(recording, None, INFO)) == []


# What a person must see of a run, besides its states.

RELEASING_ROWS = (
    (0, 6, -1, 0, 0, 0),
    (1, 3, -1, 2, 2, 2),
    (10, 4, 3, 2, 2, 0),
    (10.5, 4, 3, 2, 0, 0),
    (12.5, 4, 3, 0, 0, 0),
    (13, 6, -1, 0, 0, 0),
)


def falling(gone_s):
    """The top vacuum is gone at a time, the cylinder never, the bottom vacuum when the unwinding goes on."""
    times = [n / 10 for n in range(130)]
    samples = [
        (at, (-80.0 if at < 12.5 else 0.0, 590.0, -80.0 if at < 10 else -40.0 if at < gone_s else -9.0))
        for at in times
    ]
    return PressuresLog(("bottom", "cylinder", "top"), tuple(samples))


def test_a_releasing_actuator_has_the_colour_of_releasing_while_its_pressure_falls():
    limits = {name: {**limit, "gone_kpa": 10.0} for name, limit in INFO.limits.items()}
    figure = timeline(log(*RELEASING_ROWS), falling(10.4), replace(INFO, limits=limits))
    (blue,) = [bar for bar in bars(figure, "top_vacuum") if bar[0] == "OFF (releasing)"]
    assert blue[1:3] == (10.0, pytest.approx(10.4))
    (stuck,) = [bar for bar in bars(figure, "cylinder") if bar[0].endswith("(releasing)")]
    assert stuck[1] == 10.5
    assert stuck[2] > 13  # its pressure never went: it is not shown as gone
    (state,) = [bar for bar in bars(figure, "end_effector") if bar[0] == "RELEASING"]
    assert blue[3] == stuck[3] == state[3]


def test_a_program_that_starts_while_it_holds_a_part_releases_nothing():
    limits = {name: {**limit, "gone_kpa": 10.0} for name, limit in INFO.limits.items()}
    restarted = (0, 3, -1, 2, 2, 2), (5, 0, -1, 0, 0, 0), (5.1, 3, -1, 2, 2, 2)
    figure = timeline(log(*restarted), falling(12), replace(INFO, limits=limits))
    assert not [bar for name in NAMES for bar in bars(figure, name) if bar[0].endswith("(releasing)")]


def test_without_a_pressure_the_unwinding_shows_how_long_a_release_took():
    figure = timeline(log(*RELEASING_ROWS), None, INFO)
    found = {
        name: [
            (round(start, 6), round(end, 6))
            for state, start, end, _ in bars(figure, name)
            if state.endswith("(releasing)")
        ]
        for name in NAMES
    }
    assert found == {
        "top_vacuum": [(10.0, 10.5)],
        "cylinder": [(10.5, 12.5)],
        "bottom_vacuum": [(12.5, 13.0)],
    }


def test_a_time_out_alone_shows_no_release():
    found = [bar[1] for bar in bars(timeline(NEVER), "cylinder") if bar[0].endswith("(releasing)")]
    assert all(start > 18 for start in found)


def test_loss_and_secure_are_lines():
    limits = {"bottom_vacuum": {**INFO.limits["bottom_vacuum"], "lost_kpa": 50.0, "secure_kpa": 75.0}}
    limits["cylinder"] = {**INFO.limits["cylinder"], "lost_kpa": 490.0}
    info = replace(INFO, limits={**INFO.limits, **limits})
    figure = timeline(NEVER, PRESSURES, info)
    levels = [
        {
            line.get_label(): line.get_ydata()[0]
            for line in axes.lines
            if line.get_label() in ("lost", "secure")
        }
        for axes in figure.axes[1:]
    ]
    assert levels == [{"lost": -50.0, "secure": -75.0}, {"lost": 490.0}]
    assert {"lost > −50", "secure ≤ −75", "lost < 490"} <= set(texts(figure))
    assert overlaps(figure) == []


def test_the_tool_changer_has_a_lane():
    rows = [ChangerRow(float(at), ChangerState(state)) for at, state in enumerate((0, 1, 3, 2, 4, 1, 5))]
    figure = timeline(NEVER, changer=rows)
    assert [state for state, *_ in bars(figure, "tool_changer")] == [
        "UNKNOWN", "LOCKED", "UNLOCKING", "UNLOCKED", "LOCKING", "LOCKED", "FAULT"
    ]  # fmt: skip
    assert "Tool changer" in texts(figure)
    assert overlaps(figure) == []


@pytest.mark.parametrize(
    ("ros", "generation", "shown"), [(True, 1, "ROS 1"), (True, 2, "ROS 2"), (True, None, "ROS")]
)
def test_the_subtitle_says_which_ros(ros, generation, shown):
    info = RunInfo(description="x", ros=ros, ros_generation=generation)
    assert f"description x  ·  {shown}  ·  not simulated" in texts(timeline(NOMINAL, info=info))


def test_commands_at_one_instant_are_one_mark_and_others_keep_their_words():
    rows = [
        (0, 6, -1, 0, 0, 0),
        (1, 6, 0, 0, 0, 0),
        (1.001, 1, 2, 1, 0, 0),
        (2, 3, -1, 2, 2, 2),
        (60, 4, 3, 2, 2, 0),
    ]
    events = [(1, "lock"), (1.001, "grip; STAND_BY>GRIPPING"), (2, "GRIPPING>GRIPPED"), (60, "drop")]
    assert texts(timeline(log(*rows, events=events), None, INFO), "event") == [
        "LOCK, GRIP",
        "GRIPPED",
        "DROP",
    ]


def test_an_alarm_of_any_length_takes_no_words_from_others():
    alarms = [AlarmRow(0.5, "begun", "No valid reading of " + "something, " * 40)]
    alarms += [AlarmRow(0.5, "begun", "Another one."), AlarmRow(0.5, "begun", "A third one.")]
    shown = texts(timeline(NEVER, None, INFO, alarms), "event")
    assert shown[0].endswith("… +2")
    assert shown[1:] == [
        "GRIP",
        "Cylinder time-out 1/3",
        "Cylinder time-out 2/3",
        "Cylinder time-out 3/3 – abort",
    ]


WATCHED = (
    Watched("ee", values=((0.0, "STAND_BY"), (1.5, "GRIPPING"))),
    Watched("evidence[cylinder]", wrong=True, values=((0.0, "GONE"), (3.0, "PARTIAL"))),
    Watched(
        "Observer.x",
        wrong=True,
        points=((0.0, 0.0), (1.5, 1.5), (1.5, 0.0), (5.0, 3.5)),
        limits=(("<= GRIP_BOUND (3.4 s)", 3.4),),
        deadline_s=4.9,
    ),
)
VIOLATED = replace(
    INFO, violated="It ends.", violated_s=5.0, because="At 5 s x must be at most 3.4 s.", watched=WATCHED
)


def test_a_counterexample_shows_what_its_requirement_speaks_of():
    figure = timeline(NEVER, info=VIOLATED)
    shown = texts(figure)
    assert "VIOLATED at 5 s: It ends." in shown
    assert "At 5 s x must be at most 3.4 s." in shown
    assert "what the requirement speaks of; red: the part that does not hold" in shown
    assert {"ee", "evidence[cylinder]", "Observer.x\n[s]", "≤ GRIP_BOUND (3.4 s)"} <= set(shown)
    assert [(state, start) for state, start, *_ in bars(figure, "watched ee")] == [
        ("STAND_BY", 0.0),
        ("GRIPPING", 1.5),
    ]
    evidence = bars(figure, "watched evidence[cylinder]")
    assert [(state, round(start, 3)) for state, start, *_ in evidence] == [
        ("GONE", 0.0),
        ("PARTIAL", 3.0),
        ("PARTIAL", 5.0),
    ]
    red, before = evidence[-1][3], evidence[-2][3]
    assert red[0] > 0.6 > max(red[1:3]) + 0.2
    assert before[0] > 0.8 < min(before[1:3])
    (clock,) = (line for line in figure.axes[1].lines if line.get_label() == "clock Observer.x")
    assert list(zip(*clock.get_data(), strict=True)) == list(WATCHED[2].points)
    (limit,) = (line for line in figure.axes[1].lines if line.get_label().startswith("limit"))
    assert set(limit.get_ydata()) == {3.4}
    deadlines = [line for axes in figure.axes for line in axes.lines if line.get_label() == "deadline"]
    assert [set(line.get_xdata()) for line in deadlines] == [{4.9}, {4.9}]
    assert overlaps(figure) == []


def test_of_many_things_a_requirement_speaks_of_those_that_are_wrong_are_shown():
    many = [Watched(f"v[{number}]", wrong=number == 39, values=((0.0, "GONE"),)) for number in range(40)]
    figure = timeline(NEVER, info=replace(VIOLATED, watched=tuple(many)))
    assert "what the requirement speaks of (10 of 40); red: the part that does not hold" in texts(figure)
    assert bars(figure, "watched v[39]")
    assert not bars(figure, "watched v[20]")


def test_a_counterexample_without_a_length_is_drawn():
    log_ = log((0.0, 0, -1, 0, 0, 0))
    figure = timeline(log_, info=replace(VIOLATED, violated_s=0.0, watched=WATCHED[:2]))
    assert "VIOLATED" in texts(figure, "event")


def test_a_switch_has_a_lane_with_its_level_and_what_it_proves():
    """The line is up while it is on, and has a gap where it is not known; a switch that proves nothing has no lane."""
    rows = ((0.0, (False, True)), (1.5, (True, True)), (3.0, (None, True)), (11.5, (False, True)))
    proves = {"top_cup": {"actuator": "top_vacuum", "on": "confirmed", "off": "gone"}}
    figure = timeline(
        NOMINAL, None, replace(INFO, switches=proves), switches=SwitchesLog(("top_cup", "locked"), rows)
    )
    shown = [(word, round(start, 3)) for word, start, _, _ in bars(figure, "switch top_cup")]
    assert shown == [("off", 0.0), ("on", 1.5), ("not known", 3.0), ("off", 11.5)]
    inside = texts(figure, "inside")
    assert {"off: gone", "on: confirmed"} <= set(inside)
    (line,) = [each for each in figure.axes[0].get_lines() if each.get_label() == "switch top_cup: level"]
    off, _, on, _, unknown, *_ = line.get_ydata()
    assert on < off, "inches run downwards"
    assert unknown != unknown
    assert not bars(figure, "switch locked")
    assert overlaps(figure) == []
