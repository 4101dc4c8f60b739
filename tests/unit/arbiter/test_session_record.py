"""The session record: what it holds, and what makes it be doubted."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from end_effector_hal.arbiter.records import _storage as module
from end_effector_hal.arbiter.records._record_file import SLOT, RecordFile
from end_effector_hal.arbiter.records._session_store import RETRY_US, SessionStore, this_boot
from end_effector_hal.arbiter.records._storage import FileStorage
from end_effector_hal.arbiter.rules._session import ArbiterState, SessionRecord
from end_effector_hal.vocabulary import LastWillStep
from tests.support.keeping import BOTTOM, GRIP, LINES, TOKEN, TOP

GRIPPING = SessionRecord(
    "grip", TOKEN, GRIP, (LastWillStep(TOP), LastWillStep(BOTTOM, after_us=5)), ended=False, pid=7
)
MEMORY = ArbiterState(
    {"closed": "IL-13: the e-stop was opened."},
    (GRIPPING,),
    clean=False,
    levels=dict.fromkeys(LINES, False),
    dead=(("grip", "0" * 32),),
)


def record(folder: Path, boot: str = "boot", at: list[int] | None = None) -> SessionStore:
    clock = [0] if at is None else at
    storage, mark = (FileStorage(folder / name, durable=False) for name in ("sessions", "generation"))
    return SessionStore(storage, mark, boot, lambda: clock[0])


def test_what_is_kept_is_read(tmp_path: Path) -> None:
    assert record(tmp_path).read() is None
    first = record(tmp_path)
    first.keep(MEMORY)
    assert record(tmp_path).read() == MEMORY
    first.begin()
    left = record(tmp_path).read()
    assert left
    assert left.clients == (GRIPPING,)
    assert left.doubt.startswith("the arbiter before this one died while it changed a line")
    first.keep(MEMORY)
    assert record(tmp_path).read() == MEMORY


def test_another_start_of_the_machine_knows_nothing(tmp_path: Path) -> None:
    record(tmp_path).keep(MEMORY)
    assert record(tmp_path, "later").read() is None
    unknown = record(tmp_path, "")
    unknown.keep(MEMORY)
    assert record(tmp_path, "").read() is None
    assert this_boot()


@pytest.mark.parametrize("payload", [b"", b"{}", b"[1]", b'{"boot":"boot","memory":{"clients":3}}', b"\xff"])
def test_what_cannot_be_read_is_a_doubt(tmp_path: Path, payload: bytes) -> None:
    RecordFile(FileStorage(tmp_path / "sessions", durable=False)).keep(payload)
    left = record(tmp_path).read()
    assert left
    assert (left.clients, left.doubt) == ((), "the session record is of another version")
    (tmp_path / "sessions").write_bytes(b"hello")
    left = record(tmp_path).read()
    assert left
    assert left.doubt == "the session record is damaged"
    (tmp_path / "sessions").unlink()
    (tmp_path / "sessions").mkdir()
    left = record(tmp_path).read()
    assert left
    assert left.doubt == "the session record cannot be read (Is a directory)"


def test_a_record_that_cannot_be_kept_does_not_stay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The next arbiter would believe it: it is removed, and trouble until it is kept again."""
    first, whole = record(tmp_path), os.pwrite
    first.keep(MEMORY)

    def fails(*_: object) -> int:
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    monkeypatch.setattr(module.os, "pwrite", fails)
    first.begin()
    assert first.trouble == "Input/output error"
    assert record(tmp_path).read() is None
    first.keep(ArbiterState())
    monkeypatch.setattr(module.os, "pwrite", whole)
    first.keep(MEMORY)
    assert (first.trouble, record(tmp_path).read()) == ("", MEMORY)


def test_it_is_tried_again_at_each_change_and_every_second(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    at, tried = [0], list[int]()
    first = record(tmp_path, at=at)

    def fails(*_: object) -> None:
        tried.append(1)
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(module.os, "posix_fallocate", fails)
    for _ in range(3):
        first.keep(MEMORY)
    assert (len(tried), first.trouble) == (1, "No space left on device")
    first.keep(ArbiterState())
    assert len(tried) == 2
    at[0] = RETRY_US
    first.keep(ArbiterState())
    first.keep(ArbiterState())
    assert len(tried) == 3
    assert list(tmp_path.iterdir()) == []


def test_an_older_record_that_is_whole_is_a_doubt(tmp_path: Path) -> None:
    """Such as a copy of an earlier moment: its levels may be those that are found."""
    first = record(tmp_path)
    first.keep(MEMORY)
    copy = (tmp_path / "sessions").read_bytes()
    first.keep(ArbiterState(clean=False))
    (tmp_path / "sessions").write_bytes(copy)
    left = record(tmp_path).read()
    assert left
    assert left.doubt == "the session record is not the latest one"
    first.keep(MEMORY)
    (tmp_path / "generation").unlink()
    left = record(tmp_path).read()
    assert left
    assert left.doubt == "the session record is not the latest one"


@pytest.mark.parametrize("count", [1, 2, 3])
@pytest.mark.parametrize("lost", [(0, SLOT), (SLOT, 2 * SLOT)])
def test_a_part_that_has_gone_is_a_doubt(tmp_path: Path, count: int, lost: tuple[int, int]) -> None:
    first = record(tmp_path)
    for number in range(count):
        first.keep(ArbiterState(clean=False, faults={str(number): "it is latched"}))
    whole = (tmp_path / "sessions").read_bytes()
    for content in (
        whole[: lost[0]] + bytes(SLOT) + whole[lost[1] :],
        whole[: lost[0]],
        whole[: lost[1] - 1],
    ):
        (tmp_path / "sessions").write_bytes(content)
        left = record(tmp_path).read()
        assert left is None or left.doubt
