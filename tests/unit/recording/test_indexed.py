"""A closed segment is sorted by time and has an index for other programs; this one reads it in the order of writing."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

from end_effector_hal.recording import TraceWriter, _trace_writer, read_trace
from end_effector_hal.recording._indexed import NAME, TooLongError, remove_leftovers, write_indexed
from tests.support.patience import wait_until
from tests.unit.recording.test_trace_file import FILES, KINDS, Seen

TIMES = [30, 10, 20, 20, 5, 20, 40]


def write(folder: Path) -> Path:
    """A trace whose times go back."""
    writer = TraceWriter(folder, KINDS, now=0, attachments=FILES)
    for number, at in enumerate(TIMES * 300):
        writer.put([("seen", at, Seen(at, number, "x" * 50))])
    path = wait_until("its file", lambda: writer.path)
    writer.close()
    return path


def chunks(path: Path) -> int:
    from mcap.reader import make_reader

    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    return len(summary.chunk_indexes) if summary is not None else 0


def indexed(folder: Path) -> Path:
    """On a busy machine by the other process."""
    path = write(folder)
    wait_until("its index", lambda: chunks(path) > 1)
    return path


def numbers(path: Path) -> list[int]:
    found = read_trace(path)
    assert (found.complete, found.damaged, found.note) == (True, False, "")
    assert found.attachments == FILES
    return [record.content["number"] for record in found.records]


@pytest.fixture
def plain(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """One that was not indexed yet."""
    monkeypatch.setattr(_trace_writer, "write_indexed", lambda path, until: None)
    return write(tmp_path)


def test_a_closed_segment_is_sorted_by_time_and_has_an_index(tmp_path: Path) -> None:
    from mcap.reader import SeekingReader

    path = indexed(tmp_path)
    with path.open("rb") as file:
        reader = SeekingReader(file, validate_crcs=True)
        found = [(message.log_time, message.sequence) for _, _, message in reader.iter_messages()]
        assert found == sorted(found)
        assert [each.name for each in reader.iter_attachments()] == list(FILES)
        summary = reader.get_summary()
    assert summary.statistics.message_count == len(found) == len(TIMES) * 300
    starts = [each.message_start_time for each in summary.chunk_indexes]
    assert starts == sorted(starts)
    assert numbers(path) == list(range(len(found))), "read in the order of writing"
    assert [each.name for each in tmp_path.iterdir()] == [path.name]


def test_one_that_is_indexed_stays_as_it_is(tmp_path: Path) -> None:
    path = indexed(tmp_path)
    before = path.read_bytes()
    write_indexed(path)
    assert path.read_bytes() == before


def test_what_is_given_up_or_fails_leaves_the_segment(plain: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = plain.read_bytes()
    with pytest.raises(TooLongError):
        write_indexed(plain, 0.0)
    damaged = bytearray(before)
    damaged[len(before) // 2] ^= 1
    plain.write_bytes(damaged)
    with pytest.raises(ValueError, match="crc"):  # a new checksum would hide it
        write_indexed(plain)
    assert plain.read_bytes() == damaged
    plain.write_bytes(before)

    def fails(fd: int) -> None:
        raise OSError("the disk fails")

    with monkeypatch.context() as patched:
        patched.setattr(os, "fsync", fails)
        with pytest.raises(OSError, match="fails"):
            write_indexed(plain)
    assert plain.read_bytes() == before
    assert [each.name for each in plain.parent.iterdir()] == [plain.name]
    write_indexed(plain)
    assert chunks(plain) > 1


def test_what_a_killed_process_has_left_is_removed(plain: Path) -> None:
    beside = plain.with_name(NAME.format(plain.name))
    beside.write_bytes(plain.read_bytes()[:1000])
    assert numbers(plain)
    remove_leftovers(plain.parent)
    assert [each.name for each in plain.parent.iterdir()] == [plain.name]


def test_a_link_in_its_place_is_not_followed(plain: Path, tmp_path: Path) -> None:
    other = tmp_path / "other"
    other.write_text("precious")
    plain.with_name(NAME.format(plain.name)).symlink_to(other)
    with pytest.raises(OSError, match="symbolic"):
        write_indexed(plain)
    assert other.read_text() == "precious"


def test_a_long_segment_is_indexed_by_a_process_of_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(_trace_writer, "INDEX_S", -1.0)
    path = indexed(tmp_path)
    assert numbers(path) == list(range(len(TIMES) * 300))


def test_a_record_that_is_missing_ends_what_is_read(tmp_path: Path) -> None:
    """In a file that was cut off later, a chunk has records that were written after one that is missing."""
    path = indexed(tmp_path)
    cut = tmp_path / "cut.mcap"
    shutil.copy(path, cut)
    os.truncate(cut, path.stat().st_size // 3)
    found = read_trace(cut)
    assert not found.complete
    assert [record.content["number"] for record in found.records] == list(range(len(found.records)))
