"""switches.csv: a row per change of a level."""

import pytest

from end_effector_hal.errors import UsageError
from end_effector_hal.recording import read_switches
from end_effector_hal.recording._levels import SwitchesWriter


def test_what_is_read_is_what_was_written_and_it_is_continued(tmp_path):
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


def test_a_recording_without_it_is_read(tmp_path):
    assert read_switches(tmp_path / "switches.csv") is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time_s,open_on\n0,2\n", "csv:2: open_on is '2', expected is 1, 0 or nothing."),
        ("time_s,open\n", "csv:1: This is not a table of switches."),
        ("time_s\n", "csv:1: This is not a table of switches."),
        ("time_s,open_on\n1,0\n0,1\n", "csv:3: Time runs backwards"),
    ],
)
def test_a_bad_file_is_refused_with_file_and_line(tmp_path, text, message):
    (path := tmp_path / "switches.csv").write_text(text)
    with pytest.raises(UsageError) as caught:
        read_switches(path)
    assert message in str(caught.value)


def test_a_last_line_that_was_cut_off_is_left_out(tmp_path):
    (path := tmp_path / "switches.csv").write_text("time_s,open_on\n0,1\n1,")
    assert read_switches(path).rows == ((0.0, (True,)),)
