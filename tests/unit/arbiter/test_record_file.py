"""Records in a file of fixed size: whatever is torn, the last whole one is found, and what was begun after it."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from end_effector_hal.arbiter.records import _storage as module
from end_effector_hal.arbiter.records._record_file import SLOT, FoundRecord, RecordFile, Standing
from end_effector_hal.arbiter.records._storage import FileStorage

WORDS = [b"one", b"a longer second one", b"", b"four", b"five " * 100]


def records(path: Path) -> RecordFile:
    return RecordFile(FileStorage(path, durable=False))


def found(path: Path) -> FoundRecord:
    kept = records(path)
    try:
        return kept.read()
    finally:
        kept.close()


def test_the_last_one_counts(tmp_path: Path) -> None:
    path = tmp_path / "file"
    assert found(path) == (Standing.ABSENT, b"", 0)
    for number, word in enumerate(WORDS, 1):
        kept = records(path)
        kept.read()
        kept.keep(word, synced=True)
        kept.close()
        assert found(path) == (Standing.WHOLE, word, number)
        assert path.stat().st_size == 2 * SLOT
    assert [each.name for each in tmp_path.iterdir()] == ["file"]


def test_its_room_is_taken_at_once(tmp_path: Path) -> None:
    records(tmp_path / "file").keep(b"one")
    assert (tmp_path / "file").stat().st_blocks * 512 >= 2 * SLOT


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_a_write_that_is_torn_at_any_byte_is_seen(tmp_path: Path, count: int) -> None:
    path = tmp_path / "file"
    kept = records(path)
    for word in WORDS[:count]:
        kept.keep(word)
    before = path.read_bytes()
    kept.keep(WORDS[count])
    after = path.read_bytes()
    start = next(at for at in range(len(after)) if before[at] != after[at]) // SLOT * SLOT
    end = max(at for at in range(start, start + SLOT) if before[at] != after[at])
    for size in range(start, end + 1):
        path.write_bytes(after[:size] + before[size:])
        standing, payload, _ = found(path)
        assert payload == WORDS[count - 1]
        # before the number of the new record differs from that of the old one nothing has happened
        assert standing is (
            Standing.OUTDATED if after[:size] != before[:size] and size > start + 16 else standing
        )
        again = records(path)
        again.read()
        again.keep(b"anew")
        again.close()
        assert found(path)[:2] == (Standing.WHOLE, b"anew")


def test_a_byte_that_turned_over_is_seen(tmp_path: Path) -> None:
    path = tmp_path / "file"
    kept = records(path)
    for word in WORDS[:2]:
        kept.keep(word)
    whole = path.read_bytes()
    for place in [*range(64), *range(SLOT, SLOT + 64)]:
        if not whole[place]:
            continue
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 0x10]) + whole[place + 1 :])
        standing, payload, _ = found(path)
        # slot 0 holds the second record, slot 1 the first
        if place < SLOT:
            assert (standing, payload) != (Standing.WHOLE, WORDS[1])
        assert payload in WORDS[:2]


def test_what_was_begun_makes_the_record_outdated_until_the_next(tmp_path: Path) -> None:
    path = tmp_path / "file"
    kept = records(path)
    kept.keep(b"one")
    kept.begin()
    assert found(path)[:2] == (Standing.OUTDATED, b"one")
    kept.begin()
    kept.keep(b"two")
    assert found(path)[:2] == (Standing.WHOLE, b"two")
    kept.begin()
    again = records(path)
    assert again.read().standing is Standing.OUTDATED
    again.keep(b"three")
    assert found(path)[:2] == (Standing.WHOLE, b"three")


@pytest.mark.parametrize(
    "content", [b"\n", b"hello\n", b"x" * 2 * SLOT, b"[" * 5000, b"EEHALREC", os.urandom(2 * SLOT)]
)
def test_what_is_no_such_file_is_damaged_and_is_written_over(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "file"
    path.write_bytes(content)
    kept = records(path)
    assert kept.read() == (Standing.DAMAGED, b"", 0)
    kept.keep(b"one")
    assert found(path)[:2] == (Standing.WHOLE, b"one")
    kept.keep(b"two")
    assert found(path)[:2] == (Standing.WHOLE, b"two")


def test_a_write_of_less_than_was_given_is_gone_on_with(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, whole = tmp_path / "file", os.pwrite
    kept = records(path)
    kept.keep(b"one")
    monkeypatch.setattr(module.os, "pwrite", lambda fd, data, at: whole(fd, data[:5], at))
    kept.keep(b"the second record")
    assert found(path)[:2] == (Standing.WHOLE, b"the second record")
    monkeypatch.setattr(module.os, "pwrite", lambda *_: 0)
    with pytest.raises(OSError, match="No space"):
        kept.keep(b"three")


def test_after_a_failure_it_is_tried_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, whole = tmp_path / "file", os.pwrite
    kept = records(path)
    kept.keep(b"one")
    for number in (errno.EIO, errno.EROFS, errno.ENOSPC):

        def fails(fd: int, data: bytes, at: int, number: int = number) -> int:
            whole(fd, data[:20], at)
            raise OSError(number, os.strerror(number))

        monkeypatch.setattr(module.os, "pwrite", fails)
        with pytest.raises(OSError, match=os.strerror(number)):
            kept.keep(b"lost")
        assert found(path)[:2] == (Standing.OUTDATED, b"one")
    monkeypatch.setattr(module.os, "pwrite", whole)
    kept.keep(b"two")
    assert found(path)[:2] == (Standing.WHOLE, b"two")
    path.unlink()
    kept.close()
    with pytest.raises(FileNotFoundError):
        kept.keep(b"three")
    kept.keep(b"three")
    assert found(path)[:2] == (Standing.WHOLE, b"three")


def test_no_link_is_followed(tmp_path: Path) -> None:
    (tmp_path / "target").write_bytes(b"precious")
    (tmp_path / "file").symlink_to(tmp_path / "target")
    kept = records(tmp_path / "file")
    with pytest.raises(OSError, match="it is a link"):
        kept.read()
    kept.keep(b"one")
    assert (tmp_path / "target").read_bytes() == b"precious"
    assert found(tmp_path / "file").payload == b"one"


def test_a_record_that_is_too_long_is_refused(tmp_path: Path) -> None:
    kept = records(tmp_path / "file")
    kept.keep(b"one")
    with pytest.raises(OSError, match="File too large"):
        kept.keep(b"x" * SLOT)
    assert found(tmp_path / "file")[:2] == (Standing.WHOLE, b"one")
