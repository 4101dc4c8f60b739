"""tool_changer.csv: a row per change."""

import pytest

from end_effector_hal.errors import UsageError
from end_effector_hal.recording import ChangerRow, read_changer
from end_effector_hal.recording._levels import ChangerWriter
from end_effector_hal.vocabulary import ChangerState


def test_what_is_read_is_what_was_written_and_it_is_continued(tmp_path):
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


def test_a_recording_without_it_is_read(tmp_path):
    assert read_changer(tmp_path / "tool_changer.csv") == ()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time_s,tool_changer\n0,9\n", "csv:2: tool_changer is 9, expected is 0 to 5."),
        ("time_s,tool_changer,x\n", "csv:1: This is not a table of a tool changer."),
        ("time_s,tool_changer\n1,0\n0,1\n", "csv:3: Time runs backwards"),
    ],
)
def test_a_bad_file_is_refused_with_file_and_line(tmp_path, text, message):
    (path := tmp_path / "tool_changer.csv").write_text(text)
    with pytest.raises(UsageError) as caught:
        read_changer(path)
    assert message in str(caught.value)


def test_a_last_line_that_was_cut_off_is_left_out(tmp_path):
    (path := tmp_path / "tool_changer.csv").write_text("time_s,tool_changer\n0,1\n1,")
    assert len(read_changer(path)) == 1
