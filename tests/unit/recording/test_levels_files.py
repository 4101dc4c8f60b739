"""switches.csv, tool_changer.csv and parts.csv: a row per change."""

import pytest

from end_effector_hal.errors import UsageError
from end_effector_hal.recording import ChangerRow, read_changer, read_switches
from end_effector_hal.recording._levels import ChangerWriter, PartsWriter, SwitchesWriter
from end_effector_hal.vocabulary import ChangerState

READ = {"switches": read_switches, "tool_changer": read_changer}


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


def test_a_recording_without_them_is_read(tmp_path):
    assert read_switches(tmp_path / "switches.csv") is None
    assert read_changer(tmp_path / "tool_changer.csv") == ()


@pytest.mark.parametrize(
    ("table", "text", "message"),
    [
        ("switches", "time_s,open_on\n0,2\n", "csv:2: open_on is '2', expected is 1, 0 or nothing."),
        ("switches", "time_s,open\n", "csv:1: This is not a table of switches."),
        ("switches", "time_s\n", "csv:1: This is not a table of switches."),
        ("switches", "time_s,open_on\n1,0\n0,1\n", "csv:3: Time runs backwards"),
        ("tool_changer", "time_s,tool_changer\n0,9\n", "csv:2: tool_changer is 9, expected is 0 to 5."),
        ("tool_changer", "time_s,tool_changer,x\n", "csv:1: This is not a table of a tool changer."),
        ("tool_changer", "time_s,tool_changer\n1,0\n0,1\n", "csv:3: Time runs backwards"),
    ],
)
def test_a_bad_file_is_refused_with_file_and_line(tmp_path, table, text, message):
    (path := tmp_path / f"{table}.csv").write_text(text)
    with pytest.raises(UsageError) as caught:
        READ[table](path)
    assert message in str(caught.value)


def test_a_last_line_that_was_cut_off_is_left_out(tmp_path):
    (path := tmp_path / "switches.csv").write_text("time_s,open_on\n0,1\n1,")
    assert read_switches(path).rows == ((0.0, (True,)),)
    (path := tmp_path / "tool_changer.csv").write_text("time_s,tool_changer\n0,1\n1,")
    assert read_changer(path) == (ChangerRow(0.0, ChangerState.LOCKED),)
