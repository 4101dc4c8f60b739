"""alarms.csv: a row when a sentence becomes an alarm, and one when it is one no longer."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from end_effector_hal.errors import UsageError
from end_effector_hal.recording import AlarmRow, AlarmsWriter, read_alarms, read_story
from tests.support.trace_recordings import INFO, NOMINAL

WEAK = 'Weak grip: Top vacuum fell to 59.8 kPa, "secure" down to 60 kPa.'
LINK = "The sensor link /dev/ttyS0 is down."


@pytest.fixture
def path(tmp_path):
    return tmp_path / "alarms.csv"


def write(path, *states):
    writer = AlarmsWriter(path)
    for time_s, alarms in states:
        writer.write(time_s, alarms)
    writer.close()


def test_what_is_read_is_what_was_written(path):
    write(path, (1.0, ()), (2.0, (WEAK,)), (2.5, (WEAK,)), (3.0, (LINK, WEAK)), (4.0, (LINK,)), (5.0, ()))
    assert read_alarms(path) == (
        AlarmRow(2.0, "begun", WEAK),
        AlarmRow(3.0, "begun", LINK),
        AlarmRow(4.0, "ended", WEAK),
        AlarmRow(5.0, "ended", LINK),
    )
    assert path.read_text().splitlines()[0] == "time_s,event,alarm"


def test_a_time_that_runs_back_is_that_of_the_last_row(path):
    write(path, (2.0, (WEAK,)), (1.9, ()))
    assert [row.time_s for row in read_alarms(path)] == [2.0, 2.0]


def test_a_recording_without_the_file_has_none(path):
    assert read_alarms(path) == ()


def test_a_last_row_that_was_cut_off_is_left_out(path):
    write(path, (2.0, (LINK,)))
    whole = path.read_bytes()
    write(path, (3.0, (WEAK,)))
    rows = read_alarms(path)
    data = path.read_bytes()
    for cut in range(len(whole), len(data)):
        path.write_bytes(data[:cut])
        assert read_alarms(path) in (rows[:1], rows[:2])


@pytest.mark.parametrize("row", ["x,begun,y", "1.0,begun", "-1,begun,y", "1.0,begun,y\rz"])
def test_a_row_that_is_none_is_refused_with_its_place(path, row):
    path.write_bytes(f"time_s,event,alarm\n{row}\n".encode())
    with pytest.raises(UsageError, match=r"alarms\.csv:2"):
        read_alarms(path)


@given(st.lists(st.text(st.characters(codec="utf-8"), min_size=1, max_size=30), max_size=4))
def test_any_text_survives_on_one_line(tmp_path_factory, texts):
    path = tmp_path_factory.mktemp("alarms") / "alarms.csv"
    write(path, (1.0, tuple(texts)))
    assert [row.text for row in read_alarms(path)] == [" ".join(text.split()) for text in texts]


def test_alarms_are_moments_of_the_story_but_not_what_the_states_show():
    rows = [
        AlarmRow(3.0, "begun", WEAK),
        AlarmRow(3.1, "begun", WEAK.replace("Top", "Bottom")),
        AlarmRow(4.0, "ended", WEAK),
        AlarmRow(4.0, "begun", "Over: Top vacuum was not secure for a while."),
        AlarmRow(5.0, "begun", "GRIP_ERROR: Top vacuum was lost."),
    ]
    moments = read_story(NOMINAL, INFO, rows).moments
    assert [(m.time_s, m.text) for m in moments if m.kind == "alarm"] == [(3.0, "Weak grip")]
