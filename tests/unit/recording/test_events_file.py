"""events.csv: a row for each event."""

import pytest

from end_effector_hal.control import COMMANDS, EventKind, ToolEvent
from end_effector_hal.errors import UsageError
from end_effector_hal.recording import EventRow, EventsWriter, event_row
from end_effector_hal.recording._events import COLUMNS, read_events
from end_effector_hal.vocabulary import Cause, EndEffectorState
from tests.support.trace_recordings import NAMES

K, S = EventKind, EndEffectorState
HEADER = ",".join(COLUMNS)
EVENTS = (
    ToolEvent(0, K.COMMAND_ACCEPTED, command="grip"),
    ToolEvent(0, K.STATE_CHANGED, old=S.STAND_BY, new=S.GRIPPING),
    ToolEvent(1, K.ATTEMPT_BEGAN, 1, 20),
    ToolEvent(2, K.STATE_CHANGED, 1, 0, S.GRIPPING, S.GRIP_ERROR, Cause.TIMED_OUT),
    ToolEvent(3, K.CHANGER_CHANGED, old=0, new=5),
    ToolEvent(4, K.NOT_GONE),
)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "events.csv"


def write(path, *rows):
    with EventsWriter(path, NAMES) as writer:
        writer.write(rows)


def test_what_is_read_is_what_was_written(path):
    rows = tuple(event_row(event, event.at, NAMES) for event in EVENTS)
    write(path, *rows[:2])
    write(path, *rows[2:])
    assert read_events(path, NAMES) == rows
    assert (
        path.read_text().splitlines()[4] == "2.000000,state changed,cylinder,,GRIPPING,GRIP_ERROR,TIMED_OUT,"
    )


def test_every_kind_and_every_command_can_be_written(path):
    rows = [EventRow(0.0, kind, old=0, new=1) for kind in (K.STATE_CHANGED, K.CHANGER_CHANGED)]
    of_attempts = (K.ATTEMPT_BEGAN, K.CONFIRMED, K.TIMED_OUT, K.CLOSED_ON_NOTHING)
    rows += [EventRow(0.0, kind, "cylinder", 1) for kind in of_attempts]
    with_more = (K.STATE_CHANGED, K.CHANGER_CHANGED, *of_attempts)
    rows += [EventRow(0.0, kind) for kind in EventKind if kind not in with_more]
    rows += [EventRow(0.0, K.COMMAND_ACCEPTED, command=name) for name in COMMANDS]
    write(path, *rows)
    assert read_events(path, NAMES) == tuple(rows)


def test_a_time_that_runs_back_is_that_of_the_last_row(path):
    write(path, EventRow(2.0, K.NOT_GONE), EventRow(3.0, K.NOT_GONE))
    write(path, EventRow(1.0, K.NOT_GONE))
    assert [row.time_s for row in read_events(path, NAMES)] == [2.0, 3.0, 3.0]


def test_a_recording_without_it_has_none_and_a_last_line_that_was_cut_off_is_left_out(path):
    assert read_events(path, NAMES) is None
    write(path, EventRow(2.0, K.NOT_GONE))
    path.write_bytes(path.read_bytes() + b"3.000000,not go")
    assert read_events(path, NAMES) == (EventRow(2.0, K.NOT_GONE),)


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ("x,not gone,,,,,,", "csv:3: time_s is 'x', expected is a number."),
        ("0,not gone,,,,,,", "csv:3: Time runs backwards"),
        (
            "1,exploded,,,,,,",
            "csv:3: event is 'exploded'. Expected is one of: command accepted, attempt began",
        ),
        (
            "1,not gone,jaw,,,,,",
            "csv:3: actuator is 'jaw'. Expected is one of: nothing, bottom_vacuum, cylinder",
        ),
        ("1,attempt began,cylinder,21,,,,", "csv:3: attempt is '21'."),
        ("1,attempt began,cylinder,,,,,", "csv:3: attempt is ''. Expected is one of: 1, 2"),
        ("1,timed out,,1,,,,", "csv:3: actuator is ''. Expected is one of: bottom_vacuum"),
        ("1,state changed,,,OFF,LOCKED,,", "csv:3: new is 'LOCKED'. Expected is one of: OFF, GRIPPING"),
        ("1,not gone,,,OFF,,,", "csv:3: old is 'OFF'. Expected is one of: nothing."),
        ("1,state changed,,,OFF,GRIPPED,LAZY,", "csv:3: cause is 'LAZY'."),
        ("1,command accepted,,,,,,dance", "csv:3: command is 'dance'."),
        ("1,not gone", "csv:3: This row has 2 fields, the header names 8."),
    ],
)
def test_a_wrong_row_is_refused_with_file_and_line(path, row, message):
    path.write_text(f"{HEADER}\n1,not gone,,,,,,\n{row}\n")
    with pytest.raises(UsageError) as caught:
        read_events(path, NAMES)
    assert message in str(caught.value)


def test_a_kill_between_two_segments_loses_no_event(path):
    write(path, EventRow(2.0, K.NOT_GONE))
    path.rename(path.with_name("events-1.csv"))
    assert read_events(path, NAMES) == (EventRow(2.0, K.NOT_GONE),)


def test_a_link_that_leads_nowhere_is_not_a_recording_without_events(path):
    path.symlink_to("nowhere.csv")
    with pytest.raises(UsageError, match="Cannot be read"):
        read_events(path, NAMES)


def test_another_table_is_refused(path):
    path.write_text(f"{HEADER},more\n")
    with pytest.raises(UsageError, match=r"csv:1: This is not a table of events\."):
        read_events(path, NAMES)


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
