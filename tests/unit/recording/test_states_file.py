"""states.csv: written as it happens, read back, or refused with file and line."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from end_effector_hal.errors import ReportedError, UsageError
from end_effector_hal.recording import StatesRow, StatesWriter, read_states
from end_effector_hal.vocabulary import Command, EndEffectorState

HEADER = "time_s,end_effector,command,bottom_vacuum,cylinder\n"
NAMES = ("bottom_vacuum", "cylinder")


@pytest.fixture
def path(tmp_path):
    return tmp_path / "states.csv"


def answer(path: Path) -> str:
    try:
        read_states(path)
    except UsageError as error:
        return str(error)
    return "read"


def test_a_row_per_change_in_the_kernel_at_once(path):
    with StatesWriter(path, NAMES) as writer:
        assert path.read_text() == HEADER
        assert writer.write(0, 6, -1, [0, 0]) is True
        assert writer.write(0.5, 6, -1, [0, 0]) is False
        assert writer.write(
            1.0000004, EndEffectorState.GRIPPING, Command.GRIP, {"cylinder": 0, "bottom_vacuum": 1}
        )
        assert path.read_text() == HEADER + "0.000000,6,-1,0,0\n1.000000,1,2,1,0\n"


def test_what_is_read_is_what_was_written(path):
    with StatesWriter(path, NAMES) as writer:
        writer.write(0.25, 6, -1, [0, 0])
        writer.write(0.25, 2, 3, [0, 2])
    log = read_states(path)
    assert log.columns == ("time_s", "end_effector", "command", "bottom_vacuum", "cylinder")
    assert log.actuators == NAMES
    assert log.note == ""
    assert log.rows == (
        StatesRow(0.25, EndEffectorState.STAND_BY, Command.NONE, (0, 0)),
        StatesRow(0.25, EndEffectorState.GRIP_ERROR, Command.RELEASE, (0, 2)),
    )


@given(
    rows=st.lists(
        st.tuples(
            st.integers(0, 10**12),
            st.sampled_from(EndEffectorState),
            st.sampled_from(Command),
            st.tuples(st.integers(0, 2), st.integers(0, 2)),
        )
    )
)
def test_any_recording_comes_back_without_repetitions(tmp_path_factory, rows):
    path = tmp_path_factory.mktemp("states") / "states.csv"
    rows.sort(key=lambda row: row[0])
    expected = []
    with StatesWriter(path, NAMES) as writer:
        for micros, end_effector, command, actuators in rows:
            row = StatesRow(micros / 1e6, end_effector, command, actuators)
            changed = not expected or expected[-1].states != row.states
            assert writer.write(row.time_s, end_effector, command, actuators) is changed
            expected += [row] if changed else []
    assert read_states(path).rows == tuple(expected)


def test_a_file_is_continued_without_repeating_its_last_row(path):
    with StatesWriter(path, NAMES) as writer:
        writer.write(3.0, 6, -1, [0, 0])
    with StatesWriter(path, NAMES) as writer:
        assert writer.last == StatesRow(3.0, EndEffectorState.STAND_BY, Command.NONE, (0, 0))
        assert writer.write(4.0, 6, -1, [0, 0]) is False
        assert writer.write(5.0, 6, 2, [0, 0]) is True
    assert path.read_text() == HEADER + "3.000000,6,-1,0,0\n5.000000,6,2,0,0\n"


def test_a_row_is_never_earlier_than_the_one_before(path):
    with StatesWriter(path, NAMES) as writer:
        writer.write(3.0, 6, -1, [0, 0])
        writer.write(2.9, 6, 2, [0, 0])
    assert read_states(path).times_s == (3.0, 3.0)


@pytest.mark.parametrize("cut", ["5.0000", "5.000000,6,", "\x00\x00"])
def test_a_cut_off_row_is_removed_before_the_file_is_continued(path, cut):
    path.write_text(HEADER + "3.000000,6,-1,0,0\n" + cut)
    with StatesWriter(path, NAMES) as writer:
        writer.write(6.0, 1, 2, [1, 0])
    assert path.read_text() == HEADER + "3.000000,6,-1,0,0\n6.000000,1,2,1,0\n"


@pytest.mark.parametrize("begun", ["", "time_s,end_eff", HEADER[:-1]])
def test_a_header_that_was_cut_off_is_written_again(path, begun):
    path.write_text(begun)
    with StatesWriter(path, NAMES) as writer:
        writer.write(0, 6, -1, [0, 0])
    assert path.read_text() == HEADER + "0.000000,6,-1,0,0\n"


@pytest.mark.parametrize(
    "text", ["time_s,end_effector,command,other\n", "hello\n", "x", HEADER[:-1] + ",top\n"]
)
def test_a_file_with_another_header_is_refused_and_left_alone(path, text):
    path.write_text(text)
    with pytest.raises(UsageError, match=r"states\.csv:1: This file has another header"):
        StatesWriter(path, NAMES)
    assert path.read_text() == text


def test_two_writers_of_one_file_are_refused(path):
    with StatesWriter(path, NAMES), pytest.raises(UsageError, match="Another program is writing this file"):
        StatesWriter(path, NAMES)
    StatesWriter(path, NAMES).close()


def test_a_spoilt_last_row_is_not_continued(path):
    path.write_text(HEADER + "3.0,99,-1,0,0\n")
    with pytest.raises(UsageError, match="The last row cannot be read"):
        StatesWriter(path, NAMES)


@pytest.mark.parametrize(
    ("row", "message"),
    [
        ((0, 7, -1, [0, 0]), "Not in Table II"),
        ((0, 6, 9, [0, 0]), "Not in Table II"),
        ((0, 6, -1, [0, 3]), "Not in Table II"),
        ((0, 6, -1, [0]), "1 values for 2 actuators"),
        ((float("nan"), 6, -1, [0, 0]), "not a time"),
        ((-1, 6, -1, [0, 0]), "not a time"),
    ],
)
def test_what_is_not_in_table_ii_is_not_written(path, row, message):
    with StatesWriter(path, NAMES) as writer, pytest.raises(UsageError, match=message):
        writer.write(*row)
    assert path.read_text() == HEADER


def test_names_that_cannot_be_columns_are_refused(path):
    for names in (["a,b"], ["a", "a"], [""], ["command"], ["a\nb"]):
        with pytest.raises(UsageError):
            StatesWriter(path, names)
    assert not path.exists()


def test_a_closed_writer_and_a_missing_folder_say_so(path):
    writer = StatesWriter(path, NAMES)
    writer.close()
    writer.close()
    with pytest.raises(UsageError, match="closed"):
        writer.write(0, 6, -1, [0, 0])
    with pytest.raises(UsageError, match="Cannot be written: No such file or directory"):
        StatesWriter(path.parent / "none" / "states.csv", NAMES)


ENDLESS = """
import sys
from end_effector_hal.recording import StatesWriter
writer = StatesWriter(sys.argv[1], ["bottom_vacuum", "cylinder"])
n = 0
while True:
    writer.write(n / 1000, 6, -1, [n % 3, (n // 3) % 3])
    n += 1
    print(n, flush=True)
"""


def test_a_kill_loses_at_most_the_last_row(path):
    process = subprocess.Popen([sys.executable, "-c", ENDLESS, str(path)], stdout=subprocess.PIPE, text=True)
    done = [int(process.stdout.readline()) for _ in range(200)]
    process.send_signal(signal.SIGKILL)
    done += [int(line) for line in process.stdout.read().splitlines() if line]
    process.wait()
    process.stdout.close()
    rows = read_states(path).rows
    assert len(rows) in (done[-1], done[-1] + 1)
    assert [row.actuators for row in rows] == [(n % 3, (n // 3) % 3) for n in range(len(rows))]
    assert [row.time_s for row in rows] == [n / 1000 for n in range(len(rows))]


FULL = """
import resource, signal, sys
from end_effector_hal.errors import ReportedError
from end_effector_hal.recording import StatesWriter
writer = StatesWriter(sys.argv[1], ["bottom_vacuum", "cylinder"])
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (100, resource.RLIM_INFINITY))
n = 0
try:
    while True:
        writer.write(n, 6, -1, [n % 3, 0])
        n += 1
except ReportedError as error:
    print(error)
resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
writer.write(n, 6, -1, [n % 3, 0])
"""


def test_a_full_disk_leaves_whole_rows_and_the_next_row_fits_again(path):
    run = subprocess.run([sys.executable, "-c", FULL, str(path)], capture_output=True, text=True, check=True)
    assert "states.csv: A row could not be written: File too large." in run.stdout
    # the header has 51 bytes, a row 18: two fit into 100
    assert read_states(path).times_s == (0.0, 1.0, 2.0)
    assert issubclass(UsageError, ReportedError)


def test_what_cannot_be_opened_is_refused(tmp_path):
    with pytest.raises(UsageError, match="Cannot be read: No such file or directory"):
        read_states(tmp_path / "none.csv")
    with pytest.raises(UsageError, match="Cannot be read: Is a directory"):
        read_states(tmp_path)


@pytest.mark.parametrize("cut", ["1.5,6", "1.5,6,-1,0,", "1.5,6,-", "\x00\x00\x00"])
def test_a_cut_off_last_line_is_reported_and_dropped(path, cut):
    path.write_text(HEADER + "0,6,-1,0,0\n1,1,2,1,0\n" + cut)
    log = read_states(path)
    assert log.times_s == (0.0, 1.0)
    assert log.note == f"{path}:4: the last line is cut off and was dropped."


def test_a_last_line_that_lacks_only_its_end_is_kept(path):
    path.write_text(HEADER + "0,6,-1,0,0\n1,1,2,1,0")
    assert read_states(path).times_s == (0.0, 1.0)
    assert read_states(path).note == ""


def test_what_a_spreadsheet_makes_of_it_is_read(path):
    path.write_bytes(b"\xef\xbb\xbf" + (HEADER + "0, 6,-1,0,0\n1,1,2,1,0\n\n").replace("\n", "\r\n").encode())
    assert read_states(path).times_s == (0.0, 1.0)


@given(st.text(alphabet="0123456789,-.\n\r eE+x", max_size=80))
def test_arbitrary_numbers_are_read_or_refused(tmp_path_factory, text):
    path = tmp_path_factory.mktemp("numbers") / "states.csv"
    path.write_text(HEADER + text)
    assert answer(path).startswith(("read", f"{path}:"))
