"""events.csv, alarms.csv, switches.csv, tool_changer.csv and parts.csv: what is written, read and continued."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from end_effector_hal.control import COMMANDS, EventKind, ToolEvent
from end_effector_hal.errors import UsageError
from end_effector_hal.recording import (
    AlarmRow,
    ChangerRow,
    EventRow,
    EventsWriter,
    event_row,
    read_alarms,
    read_changer,
    read_story,
    read_switches,
)
from end_effector_hal.recording._alarms import AlarmsWriter
from end_effector_hal.recording._events import read_events
from end_effector_hal.recording._levels import ChangerWriter, PartsWriter, SwitchesWriter
from end_effector_hal.vocabulary import WEAK, Alarm, Cause, ChangerState, EndEffectorState, received_alarms
from tests.support.trace_recordings import INFO, NAMES, NOMINAL

K, S = EventKind, EndEffectorState
EVENTS = (
    ToolEvent(0, K.COMMAND_ACCEPTED, command="grip"),
    ToolEvent(0, K.STATE_CHANGED, old=S.STAND_BY, new=S.GRIPPING),
    ToolEvent(1, K.ATTEMPT_BEGAN, 1, 20),
    ToolEvent(2, K.STATE_CHANGED, 1, 0, S.GRIPPING, S.GRIP_ERROR, Cause.TIMED_OUT),
    ToolEvent(3, K.CHANGER_CHANGED, old=0, new=5),
    ToolEvent(4, K.NOT_GONE),
)


@pytest.fixture
def events_path(tmp_path):
    return tmp_path / "events.csv"


def write_events(events_path, *rows):
    with EventsWriter(events_path, NAMES) as writer:
        writer.write(rows)


def test_what_is_read_is_what_was_written(events_path):
    rows = tuple(event_row(event, event.at, NAMES) for event in EVENTS)
    write_events(events_path, *rows[:2])
    write_events(events_path, *rows[2:])
    assert read_events(events_path, NAMES) == rows
    assert (
        events_path.read_text().splitlines()[4]
        == "2.000000,state changed,cylinder,,GRIPPING,GRIP_ERROR,TIMED_OUT,"
    )


def test_every_kind_and_every_command_can_be_written(events_path):
    rows = [EventRow(0.0, kind, old=0, new=1) for kind in (K.STATE_CHANGED, K.CHANGER_CHANGED)]
    of_attempts = (K.ATTEMPT_BEGAN, K.CONFIRMED, K.TIMED_OUT, K.CLOSED_ON_NOTHING)
    rows += [EventRow(0.0, kind, "cylinder", 1) for kind in of_attempts]
    with_more = (K.STATE_CHANGED, K.CHANGER_CHANGED, *of_attempts)
    rows += [EventRow(0.0, kind) for kind in EventKind if kind not in with_more]
    rows += [EventRow(0.0, K.COMMAND_ACCEPTED, command=name) for name in COMMANDS]
    write_events(events_path, *rows)
    assert read_events(events_path, NAMES) == tuple(rows)


def test_a_time_that_runs_back_is_that_of_the_last_row(events_path):
    write_events(events_path, EventRow(2.0, K.NOT_GONE), EventRow(3.0, K.NOT_GONE))
    write_events(events_path, EventRow(1.0, K.NOT_GONE))
    assert [row.time_s for row in read_events(events_path, NAMES)] == [2.0, 3.0, 3.0]


def test_a_last_line_that_was_cut_off_is_left_out(events_path):
    write_events(events_path, EventRow(2.0, K.NOT_GONE))
    events_path.write_bytes(events_path.read_bytes() + b"3.000000,not go")
    assert read_events(events_path, NAMES) == (EventRow(2.0, K.NOT_GONE),)


def test_a_kill_between_two_segments_loses_no_event(events_path):
    write_events(events_path, EventRow(2.0, K.NOT_GONE))
    events_path.rename(events_path.with_name("events-1.csv"))
    assert read_events(events_path, NAMES) == (EventRow(2.0, K.NOT_GONE),)


def test_a_link_that_leads_nowhere_is_not_a_recording_without_events(events_path):
    events_path.symlink_to("nowhere.csv")
    with pytest.raises(UsageError, match="Cannot be read"):
        read_events(events_path, NAMES)


@pytest.mark.parametrize(
    "wrong",
    [
        ToolEvent(0, K.STATE_CHANGED, old=0, new=7),
        ToolEvent(0, K.NOT_GONE, old=0, new=1),
        ToolEvent(0, K.ATTEMPT_BEGAN, 0, 21),
        ToolEvent(0, K.COMMAND_ACCEPTED, command="1,2"),
    ],
)
def test_an_event_that_no_tool_has_makes_no_row(wrong):
    with pytest.raises(ValueError, match=r"states|command"):
        event_row(wrong, 0.0, NAMES)


# alarms.csv: a row when an alarm begins, when it is over, and when it is not shown any more.


WEAK_TOP = Alarm(WEAK, "top_vacuum", {"kpa": 59.8, "least_kpa": 60.0})
AGAIN = Alarm(WEAK, "top_vacuum", {"kpa": 62.0}, over=True)
LINK = Alarm("link.down", "", {"sensors": 'sensor link "/dev/ttyS0" is down'})


@pytest.fixture
def alarms_path(tmp_path):
    return tmp_path / "alarms.csv"


def write_alarms(alarms_path, *states):
    writer = AlarmsWriter(alarms_path)
    for time_s, alarms in states:
        writer.write(time_s, alarms)
    writer.close()


def test_alarms_that_are_read_are_those_that_were_written(alarms_path):
    write_alarms(
        alarms_path, (1.0, ()), (2.0, (WEAK_TOP,)), (2.5, (replace(WEAK_TOP),)), (3.0, (LINK, WEAK_TOP)),
        (3.5, (LINK, AGAIN)), (4.0, (LINK,)), (5.0, ()),
    )  # fmt: skip
    rows = read_alarms(alarms_path)
    assert rows == (
        AlarmRow(2.0, "begun", WEAK_TOP.text, WEAK, "top_vacuum"),
        AlarmRow(3.0, "begun", LINK.text, "link.down"),
        AlarmRow(3.5, "over", AGAIN.text, WEAK, "top_vacuum"),
        AlarmRow(4.0, "ended", AGAIN.text, WEAK, "top_vacuum"),
        AlarmRow(5.0, "ended", LINK.text, "link.down"),
    )
    assert [str(row.as_alarm()) for row in rows[:3]] == [str(WEAK_TOP), str(LINK), str(AGAIN)]
    assert alarms_path.read_text().splitlines()[0] == "time_s,event,id,about,alarm"


def test_a_time_of_an_alarm_that_runs_back_is_that_of_the_last_row(alarms_path):
    write_alarms(alarms_path, (2.0, (WEAK_TOP,)), (1.9, ()))
    assert [row.time_s for row in read_alarms(alarms_path)] == [2.0, 2.0]


def test_a_last_row_of_alarms_that_was_cut_off_is_left_out(alarms_path):
    write_alarms(alarms_path, (2.0, (LINK,)))
    whole = alarms_path.read_bytes()
    write_alarms(alarms_path, (3.0, (WEAK_TOP,)))
    rows = read_alarms(alarms_path)
    data = alarms_path.read_bytes()
    for cut in range(len(whole), len(data)):
        alarms_path.write_bytes(data[:cut])
        assert read_alarms(alarms_path) in (rows[:1], rows[:2])


@given(st.lists(st.text(st.characters(codec="utf-8"), min_size=1, max_size=30), max_size=4))
def test_any_text_survives_on_one_line(tmp_path_factory, texts):
    alarms_path = tmp_path_factory.mktemp("alarms") / "alarms.csv"
    alarms = received_alarms(texts)
    write_alarms(alarms_path, (1.0, alarms))
    found = {each.key: each.text for each in alarms}
    assert [row.text for row in read_alarms(alarms_path)] == [
        " ".join(text.split()) for text in found.values()
    ]


def test_alarms_are_moments_of_the_story_but_not_what_the_states_show():
    rows = [
        AlarmRow(3.0, "begun", WEAK_TOP.text, WEAK, "top_vacuum"),
        AlarmRow(3.1, "begun", WEAK_TOP.text.replace("Top", "Bottom"), WEAK, "bottom_vacuum"),
        AlarmRow(4.0, "over", AGAIN.text, WEAK, "top_vacuum"),
        AlarmRow(5.0, "begun", "GRIP_ERROR: Top vacuum was lost.", "grip.error"),
    ]
    moments = read_story(NOMINAL, INFO, rows).moments
    assert [(m.time_s, m.text) for m in moments if m.kind == "alarm"] == [(3.0, "Weak grip")]


# switches.csv, tool_changer.csv and parts.csv: a row per change.


def test_switches_that_are_read_are_those_that_were_written_and_they_are_continued(tmp_path):
    path = tmp_path / "switches.csv"
    with SwitchesWriter(path, ("open", "closed")) as writer:
        assert writer.write(0.0, {"open": True})
        assert not writer.write(0.5, {"open": True, "closed": None})
        assert writer.write(1.0, {"open": False, "closed": True, "other": True})
    with SwitchesWriter(path, ("open", "closed")) as writer:
        assert not writer.write(2.0, {"open": False, "closed": True})
        assert writer.write(3.0, {"closed": True})
    log = read_switches(path)
    assert (log.channels, log.times_s) == (("open", "closed"), (0.0, 1.0, 3.0))
    assert log.levels("open") == (True, False, None)
    assert log.levels("closed") == (None, True, True)


def test_states_of_the_changer_that_are_read_are_those_that_were_written_and_they_are_continued(tmp_path):
    path = tmp_path / "tool_changer.csv"
    with ChangerWriter(path) as writer:
        states = (ChangerState.UNKNOWN, ChangerState.LOCKED, ChangerState.LOCKED)
        assert [writer.write(at / 2, state) for at, state in enumerate(states)] == [True, True, False]
    with ChangerWriter(path) as writer:
        assert not writer.write(2.0, ChangerState.LOCKED)
        assert writer.write(3.0, ChangerState.FAULT)
    assert read_changer(path) == (
        ChangerRow(0.0, ChangerState.UNKNOWN), ChangerRow(0.5, ChangerState.LOCKED), ChangerRow(3.0, ChangerState.FAULT)
    )  # fmt: skip


def test_parts_are_written_where_another_one_is_gripped_and_are_continued(tmp_path):
    path = tmp_path / "parts.csv"
    with PartsWriter(path) as writer:
        assert [writer.write(at / 2, part) for at, part in enumerate(("", "lid", "lid"))] == [
            True,
            True,
            False,
        ]
    with PartsWriter(path) as writer:
        assert not writer.write(2.0, "lid")
        assert writer.write(3.0, "")
    assert path.read_text() == "time_s,part\n0.000000,\n0.500000,lid\n3.000000,\n"
    path.write_text("time_s,part\n0.0,two words\n")
    with pytest.raises(UsageError, match=r"parts.csv: The last row cannot be read"):
        PartsWriter(path)


def test_a_last_line_of_levels_that_was_cut_off_is_left_out(tmp_path):
    (path := tmp_path / "switches.csv").write_text("time_s,open_on\n0,1\n1,")
    assert read_switches(path).rows == ((0.0, (True,)),)
    (path := tmp_path / "tool_changer.csv").write_text("time_s,tool_changer\n0,1\n1,")
    assert read_changer(path) == (ChangerRow(0.0, ChangerState.LOCKED),)
