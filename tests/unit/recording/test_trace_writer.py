"""A disk that is full, that hangs, and that works again: what is lost is counted, and whoever records never waits."""

from __future__ import annotations

import errno
import logging
import os
import shutil
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from end_effector_hal.errors import UsageError
from end_effector_hal.recording import (
    Gap,
    Opening,
    RecordingLimits,
    TraceWriter,
    _files,
    _trace_writer,
    read_trace,
)
from end_effector_hal.recording._files import lock, make_room
from tests.support.patience import PATIENCE_S, wait_until


@dataclass
class Head:
    at: int
    segment: int
    follows: bool
    gap: Gap | None


@dataclass
class Seen:
    at: int
    number: int


KINDS = {"header": Head, "state": Seen, "seen": Seen}


def header(opening: Opening) -> Head:
    return Head(opening.at, opening.segment, opening.follows, opening.gap)


class Disk:
    """What the writer's thread calls instead of ``os.write``."""

    def __init__(self) -> None:
        self.works, self.error, self.torn = threading.Event(), 0, 0
        self.works.set()
        self.hangs = threading.Event()

    def write(self, fd: int, data: bytes) -> int:
        if not self.works.is_set():
            self.hangs.set()
            self.works.wait()
        if self.torn:
            torn, self.torn, self.error = self.torn, 0, errno.ENOSPC
            return os.write(fd, data[:torn])
        if self.error:
            raise OSError(self.error, os.strerror(self.error))
        return os.write(fd, data)


@pytest.fixture
def disk(monkeypatch: pytest.MonkeyPatch) -> Iterator[Disk]:
    made = Disk()

    class Os:
        def __getattr__(self, name: str) -> object:
            return made.write if name == "write" else getattr(os, name)

    monkeypatch.setattr(_files, "os", Os())
    monkeypatch.setattr(_trace_writer, "RETRY_S", 0.01)
    yield made
    made.works.set()


class Recording:
    """Whoever records: a number after the other, and its state when that is wanted."""

    def __init__(self, folder: Path, limits: RecordingLimits | None = None) -> None:
        self.told: list[str] = []
        self.writer = TraceWriter(
            folder, KINDS, now=0, attachments={}, header=header, limits=limits,
            on_trouble=lambda: self.told.append(self.writer.trouble),
        )  # fmt: skip
        self.number = 0

    def say(self, count: int = 1) -> None:
        for _ in range(count):
            self.number += 1
            self.writer.put([("seen", self.number, Seen(self.number, self.number))])
            if self.writer.wants_state:
                self.writer.begin(self.number, [("state", self.number, Seen(self.number, self.number))])

    def drain(self) -> None:
        end = time.monotonic() + PATIENCE_S
        while self.writer._queued or self.writer._ordered:
            assert time.monotonic() < end
            time.sleep(0)


def contents(path: Path) -> tuple[Head, list[int]]:
    found = read_trace(path)
    head, *rest = (record.content for record in found.records)
    gap = head.pop("gap")
    return Head(**head, gap=Gap(**gap) if gap else None), [each["number"] for each in rest]


def test_a_full_disk_loses_what_it_cannot_take_and_says_how_much(
    tmp_path: Path, disk: Disk, caplog: pytest.LogCaptureFixture
) -> None:
    recording = Recording(tmp_path)
    recording.say(3)
    recording.drain()
    disk.error = errno.ENOSPC
    with caplog.at_level(logging.WARNING):
        recording.say()
        wait_until("trouble", lambda: recording.told)
        recording.say(6)
    trouble = f"The trace is not recorded: No space left on device ({tmp_path})."
    assert recording.told == [trouble]
    assert caplog.text.count(trouble) == 1
    disk.error = 0
    wait_until("the disk", lambda: recording.writer.wants_state)
    recording.say(3)
    wait_until("it is recorded again", lambda: not recording.writer.trouble)
    recording.say(2)
    recording.writer.close()
    assert recording.told == [trouble, ""]
    assert contents(tmp_path / "hal.mcap") == (Head(0, 1, False, None), [1, 2, 3])
    gap = Gap(4, 8, "No space left on device")
    # number 11 brought the state of the new segment
    assert contents(tmp_path / "hal-2.mcap") == (Head(11, 2, False, gap), [11, 12, 13, 14, 15])
    assert read_trace(tmp_path / "hal-2.mcap").complete


def test_what_is_written_in_part_leaves_no_torn_record(tmp_path: Path, disk: Disk) -> None:
    recording = Recording(tmp_path)
    recording.say(3)
    recording.drain()
    size = (tmp_path / "hal.mcap").stat().st_size
    disk.torn = 20
    recording.say()
    wait_until("trouble", lambda: recording.writer.trouble)
    recording.writer.close()
    assert (tmp_path / "hal.mcap").stat().st_size == size
    assert contents(tmp_path / "hal.mcap")[1] == [1, 2, 3]
    assert "its disk was full" in read_trace(tmp_path / "hal.mcap").note


def test_a_disk_that_hangs_delays_nobody(tmp_path: Path, disk: Disk, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_trace_writer, "MOST_WAITING", 10)
    monkeypatch.setattr(_trace_writer, "END_S", 0.05)
    recording = Recording(tmp_path)
    recording.say(2)
    recording.drain()
    disk.works.clear()
    recording.say()
    assert disk.hangs.wait(60)
    recording.say(30)  # would never return if it waited
    assert "the disk is too slow for the records" in recording.writer.trouble
    disk.works.set()
    wait_until("the disk", lambda: recording.writer.wants_state)
    recording.say()
    wait_until("it is recorded again", lambda: not recording.writer.trouble)
    disk.works.clear()
    recording.say()
    recording.writer.close()  # returns all the same
    disk.works.set()
    recording.writer._thread.join(60)
    first = contents(tmp_path / "hal.mcap")[1]
    assert first == list(range(1, len(first) + 1))
    assert 12 <= len(first) <= 13  # the batch that hung, and what had room
    assert read_trace(tmp_path / "hal.mcap").complete
    gap = contents(tmp_path / "hal-2.mcap")[0].gap
    assert (gap.since, len(first) + gap.records) == (len(first) + 1, 34)


def test_a_record_that_cannot_be_written_is_a_gap(tmp_path: Path, disk: Disk) -> None:
    recording = Recording(tmp_path)
    recording.say(2)
    recording.writer.put([("unknown", 3, Seen(3, 3))])
    wait_until("trouble", lambda: recording.writer.trouble)
    wait_until("the next segment", lambda: recording.writer.wants_state)
    recording.say()
    wait_until("it is recorded again", lambda: not recording.writer.trouble)
    recording.writer.close()
    assert contents(tmp_path / "hal.mcap")[1] == [1, 2]
    assert contents(tmp_path / "hal-2.mcap")[0].gap is not None


def test_a_full_disk_at_the_beginning_is_tried_again(tmp_path: Path, disk: Disk) -> None:
    disk.error = errno.ENOSPC
    recording = Recording(tmp_path)
    wait_until("trouble", lambda: recording.writer.trouble)
    recording.say(5)
    assert list(tmp_path.glob("*.mcap")) == []
    disk.error = 0
    wait_until("the disk", lambda: recording.writer.wants_state)
    recording.say(2)
    recording.writer.close()
    assert contents(tmp_path / "hal.mcap") == (
        Head(6, 1, False, Gap(0, 6, "No space left on device")),
        [6, 7],
    )


def test_a_file_that_was_made_in_vain_is_removed(tmp_path: Path, disk: Disk) -> None:
    recording = Recording(tmp_path)
    recording.drain()
    disk.error = errno.EIO
    recording.say()
    wait_until("trouble", lambda: recording.writer.trouble)
    disk.error = 0
    wait_until("the disk", lambda: recording.writer.wants_state)
    recording.writer.close()  # before anybody has given a state
    assert [path.name for path in tmp_path.glob("*.mcap")] == ["hal.mcap"]


def test_a_folder_that_goes_is_trouble_and_is_made_again(tmp_path: Path, disk: Disk) -> None:
    folder = tmp_path / "run"
    recording = Recording(folder)
    recording.say(3)
    recording.drain()
    shutil.rmtree(folder)
    recording.say()
    wait_until("the folder", lambda: recording.writer.wants_state)
    recording.say(2)
    recording.writer.close()
    assert "No such file or directory" in recording.told[0]
    assert contents(folder / "hal.mcap") == (
        Head(5, 2, False, Gap(4, 2, "No such file or directory")),
        [5, 6],
    )


@pytest.mark.timeout(20)
def test_a_pipe_in_the_place_of_a_trace_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "hal.mcap")
    with pytest.raises(UsageError, match="this is no file"):
        read_trace(tmp_path / "hal.mcap")


def test_a_folder_that_cannot_be_made_is_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    recording = Recording(tmp_path / "file")
    wait_until("trouble", lambda: recording.writer.trouble)
    recording.writer.close()
    assert "This is not a folder" in recording.writer.trouble


def test_segments_are_as_long_as_they_may_be(tmp_path: Path) -> None:
    recording = Recording(tmp_path, RecordingLimits(2_000, 1_000_000))
    for _ in range(200):
        recording.say()
        recording.drain()
    recording.writer.close()
    paths = sorted(tmp_path.glob("*.mcap"), key=lambda path: int(path.stem.partition("-")[2] or 1))
    found = [contents(path) for path in paths]
    assert [head.segment for head, _ in found] == list(range(1, len(found) + 1))
    assert all(head.follows for head, _ in found[1:])
    # each but the first begins with a state, which repeats the last number
    assert [number for place, (_, rest) in enumerate(found) for number in rest[bool(place) :]] == list(
        range(1, 201)
    )
    assert len({len(rest) for _, rest in found[1:-1]}) <= 2
    sizes = [path.stat().st_size for path in paths[:-1]]
    assert max(sizes) - min(sizes) < 300


@pytest.fixture
def small(tmp_path: Path) -> Callable[[], list[str]]:
    def names() -> list[str]:
        return sorted(path.name for path in tmp_path.iterdir())

    return names


def test_the_oldest_segments_go_first_and_never_the_one_being_written(
    tmp_path: Path, small: Callable[[], list[str]]
) -> None:
    limits = RecordingLimits(1_000, 9_000)
    for age, name in enumerate(["hal.mcap", "states-1.csv", "alarms-2.csv", "hal-2.mcap", "notes.mcap"]):
        path = tmp_path / name
        path.write_bytes(b"x" * 3_000)
        os.utime(path, ns=(age, age))
    open_one = os.open(tmp_path / "hal.mcap", os.O_RDWR)
    try:
        assert lock(open_one)
        assert make_room(tmp_path, limits) == ("states-1.csv", "alarms-2.csv")
    finally:
        os.close(open_one)
    assert small() == ["hal-2.mcap", "hal.mcap", "notes.mcap", "removed.csv"]
    rows = (tmp_path / "removed.csv").read_text().splitlines()
    assert rows[0] == "time,file,bytes"
    assert [row.partition(",")[2] for row in rows[1:]] == ["states-1.csv,3000", "alarms-2.csv,3000"]
    assert make_room(tmp_path, limits) == ()


def test_a_folder_stays_within_its_limit(tmp_path: Path) -> None:
    limits = RecordingLimits(2_000, 60_000)
    recording = Recording(tmp_path, limits)
    largest = 0
    for _ in range(2_000):
        recording.say()
        recording.drain()
        largest = max(largest, sum(path.stat().st_size for path in tmp_path.glob("*.mcap")))
    recording.writer.close()
    removed = (tmp_path / "removed.csv").read_text().splitlines()[1:]
    assert len(removed) > 5
    assert 40_000 < largest <= 62_000  # a segment may be longer by its preamble and one batch
    heads = [contents(path)[0].segment for path in tmp_path.glob("*.mcap")]
    assert min(heads) == len(removed) + 1


@pytest.mark.parametrize(("segment", "total"), [(0, 100), (-1, 100), (100, 600), (100, 0)])
def test_limits_that_cannot_be_kept_are_refused(segment: int, total: int) -> None:
    with pytest.raises(UsageError, match="A recording cannot be kept"):
        RecordingLimits(segment, total)


def test_limits_from_a_command_line() -> None:
    assert RecordingLimits.of_megabytes(0.5, 10) == RecordingLimits(500_000, 10_000_000)
    for segment_mb in (float("nan"), float("inf"), -1.0):
        with pytest.raises(UsageError, match="megabytes"):
            RecordingLimits.of_megabytes(segment_mb, 1000)
