"""The journal of the latched faults: on the disk in a moment, and nobody waits for a disk that fails or hangs."""

from __future__ import annotations

import errno
import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from end_effector_hal.arbiter.records import _journal as module
from end_effector_hal.arbiter.records import _storage as storage_module
from end_effector_hal.arbiter.records._journal import PATIENCE_US, Journal, JournalEntry, JournalThread
from end_effector_hal.arbiter.records._record_file import SLOT, RecordFile
from end_effector_hal.arbiter.records._storage import FileStorage
from tests.support.patience import PATIENCE_S, wait_until

E_STOP = {"closed": "IL-13: the e-stop was opened."}
IL_03 = {"IL-03 unlock": "IL-03: unlock was active too long."}


class Clock:
    now = 0

    def __call__(self) -> int:
        return self.now


def journal(folder: Path, clock: Clock | None = None) -> Journal:
    return Journal(FileStorage(folder / "journal", durable=True), "boot", clock or Clock())


def test_what_is_kept_is_read(tmp_path: Path) -> None:
    assert journal(tmp_path).read() == JournalEntry({})
    for faults in ({}, E_STOP, {**E_STOP, **IL_03}, IL_03):
        first = journal(tmp_path)
        first.read()
        first.keep(faults)
        assert first.write_next()
        assert journal(tmp_path).read() == JournalEntry(faults, clean=False, boot="boot")
        first.keep(faults, clean=True)
        assert first.write_next()
        assert journal(tmp_path).read() == JournalEntry(faults, clean=True, boot="boot")
    assert Journal(None, "boot", Clock()).read() == JournalEntry({})


class Power:
    """Keeps what is certainly on the disk: what was synced, under a name that was synced."""

    def __init__(self, path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self.path, self.safe, self._synced = path, b"", dict[int, bytes]()
        for name in ("fsync", "fdatasync"):
            monkeypatch.setattr(storage_module.os, name, self._around(getattr(os, name)))

    def _around(self, sync):  # type: ignore[no-untyped-def]
        def synced(fd: int) -> None:
            sync(fd)
            where = Path(os.readlink(f"/proc/self/fd/{fd}"))
            if where.is_dir():
                self.safe = self._synced.get(self.path.stat().st_ino, b"")
            else:
                self._synced[where.stat().st_ino] = where.read_bytes()
                self.safe = where.read_bytes() if where == self.path else self.safe

        return synced

    def goes(self, folder: Path) -> JournalEntry:
        folder.mkdir(exist_ok=True)
        (folder / "journal").write_bytes(self.safe)
        return journal(folder).read()


def test_what_was_written_survives_a_loss_of_power(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    power, kept = Power(tmp_path / "journal", monkeypatch), journal(tmp_path)
    kept.read()
    for faults in (E_STOP, {}, IL_03, {**IL_03, **E_STOP}):
        kept.keep(faults)
        assert kept.write_next()
        assert power.goes(tmp_path / "after").faults == faults


def test_a_disk_that_is_full_at_the_start_is_trouble_until_it_is_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    kept, whole = journal(tmp_path), os.posix_fallocate
    monkeypatch.setattr(storage_module.os, "posix_fallocate", full)
    kept.read()
    for faults in (E_STOP, IL_03):
        kept.keep(faults)
        assert not kept.write_next()
        assert kept.trouble == "No space left on device"
    assert caplog.text.count("cannot be written: No space left on device") == 1
    monkeypatch.setattr(storage_module.os, "posix_fallocate", whole)
    assert kept.write_next()
    assert kept.trouble == ""
    assert journal(tmp_path).read().faults == IL_03


def test_a_disk_that_does_not_answer_is_trouble(tmp_path: Path) -> None:
    clock = Clock()
    kept = journal(tmp_path, clock)
    kept.read()
    kept.keep(E_STOP)
    clock.now = PATIENCE_US
    assert kept.trouble == ""
    clock.now += 1
    assert kept.trouble == "the disk does not answer"
    assert kept.write_next()
    assert kept.trouble == ""


def test_what_is_wanted_again_before_it_was_written_is_no_trouble(tmp_path: Path) -> None:
    clock = Clock()
    kept = journal(tmp_path, clock)
    kept.read()
    kept.keep({})
    kept.write_next()
    kept.keep(E_STOP)
    kept.keep({})
    assert kept.write_next()
    clock.now = 2 * PATIENCE_US
    assert kept.trouble == ""


@pytest.mark.parametrize("content", [b"\n", b"hello\n", b"0" * 2 * SLOT, b"00000000 [", b"\xff" * 5000])
def test_what_is_no_journal_is_a_doubt(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "journal").write_bytes(content)
    found = journal(tmp_path).read()
    assert (found.faults, found.clean, found.doubt) == ({}, False, "its journal is damaged")


def test_a_torn_record_is_a_doubt_and_the_one_before_counts(tmp_path: Path) -> None:
    kept = journal(tmp_path)
    for faults in (IL_03, E_STOP):
        kept.keep(faults)
        kept.write_next()
    RecordFile(later := FileStorage(tmp_path / "journal", durable=True)).read()
    content = (tmp_path / "journal").read_bytes()
    later.write(SLOT, content[SLOT : SLOT + 8] + (9).to_bytes(8, "little"))
    found = journal(tmp_path).read()
    assert found == JournalEntry(
        E_STOP, clean=False, boot="boot", doubt="the last record of its journal is torn"
    )


@pytest.mark.parametrize("payload", [b"", b"{}", b"[]", b'{"boot":"b","clean":true,"faults":[]}'])
def test_a_record_of_another_version_is_a_doubt(tmp_path: Path, payload: bytes) -> None:
    RecordFile(FileStorage(tmp_path / "journal", durable=True)).keep(payload)
    assert journal(tmp_path).read().doubt == "its journal is of another version"


def test_a_text_that_nobody_can_encode_is_read(tmp_path: Path) -> None:
    payload = rb'{"boot":"b","clean":false,"faults":{"x\ud800":"IL-04:\nb\udfffits\u0000"}}'
    RecordFile(FileStorage(tmp_path / "journal", durable=True)).keep(payload)
    assert journal(tmp_path).read().faults == {"x?": "IL-04: b?its?"}


# The thread that waits for the disk


class Hanging(FileStorage):
    """A disk that does not answer until it is let go."""

    def __init__(self, path: Path) -> None:
        super().__init__(path, durable=True)
        self.answers = threading.Event()
        self.answers.set()

    def read(self) -> bytes:
        self.answers.wait()
        return super().read()

    def sync(self) -> None:
        self.answers.wait()
        super().sync()


@contextmanager
def thread(storage: FileStorage) -> Iterator[JournalThread]:
    running = JournalThread(Journal(storage, "boot", Clock()))
    yield running
    running.close({}, {})


@pytest.mark.wall
def test_nobody_waits_for_a_disk_that_hangs(tmp_path: Path) -> None:
    disk = Hanging(tmp_path / "journal")
    with thread(disk) as running:
        assert running.read() == JournalEntry({})
        running.keep({}, {})
        wait_until("the file", lambda: journal(tmp_path).read().boot == "boot")
        disk.answers.clear()
        running.keep(E_STOP, {})
        running.keep(IL_03, {})
        disk.answers.set()
        wait_until("the last of them", lambda: journal(tmp_path).read().faults == IL_03)
    assert journal(tmp_path).read() == JournalEntry({}, clean=True, boot="boot")


def silent_with_e_stop(folder: Path) -> Hanging:
    """A disk that has kept a fault, and does not answer."""
    before = journal(folder)
    before.keep(E_STOP)
    before.write_next()
    disk = Hanging(folder / "journal")
    disk.answers.clear()
    return disk


@pytest.mark.wall
def test_what_is_read_late_is_not_written_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "READ_S", 0.05)
    disk = silent_with_e_stop(tmp_path)
    with thread(disk) as running:
        assert running.read().doubt == "its journal cannot be read (the disk does not answer)"
        running.keep({}, {})
        disk.answers.set()
        found = list[JournalEntry | None]()
        wait_until("the late one", lambda: found.append(running.late()) or found[-1])
        assert found[-1] == JournalEntry(E_STOP, clean=False, boot="boot")
        assert running.late() is None
        wait_until("it is written", lambda: journal(tmp_path).read().faults == {})


@pytest.mark.wall
@pytest.mark.parametrize("answers", [False, True])
def test_what_was_not_read_before_the_end_is_still_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, *, answers: bool
) -> None:
    monkeypatch.setattr(module, "READ_S", 0.05)
    disk = silent_with_e_stop(tmp_path)
    running = JournalThread(Journal(disk, "boot", Clock()))
    assert running.read().unread
    if answers:
        monkeypatch.setattr(module, "READ_S", PATIENCE_S)
        disk.answers.set()
    running.close(IL_03, {})
    disk.answers.set()
    running._thread.join(0.2)  # it would write now
    assert journal(tmp_path).read().faults == (E_STOP | IL_03 if answers else E_STOP)


@pytest.mark.wall
def test_what_could_not_be_written_is_tried_again_by_itself(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "RETRY_S", 0.01)
    folder = tmp_path / "folder"
    with thread(FileStorage(folder / "journal", durable=True)) as running:
        running.read()
        running.keep(E_STOP, {})
        wait_until("trouble", lambda: running.trouble == "No such file or directory")
        folder.mkdir()
        wait_until("no trouble", lambda: not running.trouble)
        assert journal(folder).read().faults == E_STOP
