"""Where commands write: a file whole or not at all, and never in the place of what is no file."""

from __future__ import annotations

import os
import stat
import threading
from pathlib import Path

import pytest

from end_effector_hal.cli._options import write_whole
from end_effector_hal.errors import UsageError


def test_a_pipe_stays_a_pipe_and_gets_the_data(tmp_path: Path) -> None:
    pipe, got = tmp_path / "pipe", list[bytes]()
    os.mkfifo(pipe)
    reader = threading.Thread(target=lambda: got.append(pipe.read_bytes()), daemon=True)
    reader.start()
    write_whole(pipe, b"data")
    assert stat.S_ISFIFO(pipe.stat().st_mode), "as a device in /dev would be gone"
    reader.join(10.0)
    assert got == [b"data"]


def test_a_link_stays_a_link(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    link, file = tmp_path / "link", tmp_path / "there" / "file"
    link.symlink_to(file)
    for data in (b"new", b"newer"):
        write_whole(link, data)
        assert (link.is_symlink(), file.read_bytes()) == (True, data)
    assert [each.name for each in file.parent.iterdir()] == ["file"]


def test_what_cannot_be_written_is_a_sentence(tmp_path: Path) -> None:
    for path, why in (
        (tmp_path, "Is a directory"),
        (tmp_path / "no" / "file", "No such file"),
        (Path("/dev/full"), "No space"),
    ):
        with pytest.raises(UsageError, match=f"The file cannot be written: {why}"):
            write_whole(path, b"data")
    assert not list(tmp_path.iterdir())
