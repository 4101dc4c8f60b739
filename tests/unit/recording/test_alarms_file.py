"""alarms.csv: a row when an alarm begins, when it is over, and when it is not shown any more."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from end_effector_hal.errors import UsageError
from end_effector_hal.recording import AlarmRow, read_alarms, read_story
from end_effector_hal.recording._alarms import AlarmsWriter
from end_effector_hal.vocabulary import WEAK, Alarm, received_alarms
from tests.support.trace_recordings import INFO, NOMINAL

WEAK_TOP = Alarm(WEAK, "top_vacuum", {"kpa": 59.8, "least_kpa": 60.0})
AGAIN = Alarm(WEAK, "top_vacuum", {"kpa": 62.0}, over=True)
LINK = Alarm("link.down", "", {"sensors": 'sensor link "/dev/ttyS0" is down'})


@pytest.fixture
def path(tmp_path):
    return tmp_path / "alarms.csv"


def write(path, *states):
    writer = AlarmsWriter(path)
    for time_s, alarms in states:
        writer.write(time_s, alarms)
    writer.close()


def test_what_is_read_is_what_was_written(path):
    write(
        path, (1.0, ()), (2.0, (WEAK_TOP,)), (2.5, (replace(WEAK_TOP),)), (3.0, (LINK, WEAK_TOP)),
        (3.5, (LINK, AGAIN)), (4.0, (LINK,)), (5.0, ()),
    )  # fmt: skip
    rows = read_alarms(path)
    assert rows == (
        AlarmRow(2.0, "begun", WEAK_TOP.text, WEAK, "top_vacuum"),
        AlarmRow(3.0, "begun", LINK.text, "link.down"),
        AlarmRow(3.5, "over", AGAIN.text, WEAK, "top_vacuum"),
        AlarmRow(4.0, "ended", AGAIN.text, WEAK, "top_vacuum"),
        AlarmRow(5.0, "ended", LINK.text, "link.down"),
    )
    assert [str(row.as_alarm()) for row in rows[:3]] == [str(WEAK_TOP), str(LINK), str(AGAIN)]
    assert path.read_text().splitlines()[0] == "time_s,event,id,about,alarm"


def test_a_time_that_runs_back_is_that_of_the_last_row(path):
    write(path, (2.0, (WEAK_TOP,)), (1.9, ()))
    assert [row.time_s for row in read_alarms(path)] == [2.0, 2.0]


def test_a_recording_without_the_file_has_none(path):
    assert read_alarms(path) == ()


def test_a_last_row_that_was_cut_off_is_left_out(path):
    write(path, (2.0, (LINK,)))
    whole = path.read_bytes()
    write(path, (3.0, (WEAK_TOP,)))
    rows = read_alarms(path)
    data = path.read_bytes()
    for cut in range(len(whole), len(data)):
        path.write_bytes(data[:cut])
        assert read_alarms(path) in (rows[:1], rows[:2])


@pytest.mark.parametrize("row", ["x,begun,,,y", "1.0,begun,y", "-1,begun,,,y", "1.0,begun,,,y\rz"])
def test_a_row_that_is_none_is_refused_with_its_place(path, row):
    path.write_bytes(f"time_s,event,id,about,alarm\n{row}\n".encode())
    with pytest.raises(UsageError, match=r"alarms\.csv:2"):
        read_alarms(path)


@given(st.lists(st.text(st.characters(codec="utf-8"), min_size=1, max_size=30), max_size=4))
def test_any_text_survives_on_one_line(tmp_path_factory, texts):
    path = tmp_path_factory.mktemp("alarms") / "alarms.csv"
    alarms = received_alarms(texts)
    write(path, (1.0, alarms))
    found = {each.key: each.text for each in alarms}
    assert [row.text for row in read_alarms(path)] == [" ".join(text.split()) for text in found.values()]


def test_alarms_are_moments_of_the_story_but_not_what_the_states_show():
    rows = [
        AlarmRow(3.0, "begun", WEAK_TOP.text, WEAK, "top_vacuum"),
        AlarmRow(3.1, "begun", WEAK_TOP.text.replace("Top", "Bottom"), WEAK, "bottom_vacuum"),
        AlarmRow(4.0, "over", AGAIN.text, WEAK, "top_vacuum"),
        AlarmRow(5.0, "begun", "GRIP_ERROR: Top vacuum was lost.", "grip.error"),
    ]
    moments = read_story(NOMINAL, INFO, rows).moments
    assert [(m.time_s, m.text) for m in moments if m.kind == "alarm"] == [(3.0, "Weak grip")]
