"""File operations of a recording: locks while a file is written, all-or-nothing writes, and numbered files."""

from __future__ import annotations

import errno
import os
import re
import stat
from contextlib import suppress
from pathlib import Path


def lock(fd: int) -> bool:
    """Lock a file that is being written, until this process ends; return False if another process holds the lock."""
    try:
        import fcntl

        fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except (ImportError, OSError):
        return True  # a system or a file system without these locks
    return True


def is_written(path: Path) -> bool:
    """Return whether a process writes a segment now; raises OSError."""
    fd = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    try:
        return not lock(fd)
    finally:
        os.close(fd)


def still_there(path: Path, fd: int) -> None:
    """Raise OSError if this open file is no longer at its path, because everything written to it would be lost."""
    found, own = os.stat(path), os.fstat(fd)
    if (found.st_dev, found.st_ino) != (own.st_dev, own.st_ino):
        raise OSError(errno.ENOENT, "another file is in its place")


def append_whole(fd: int, data: bytes) -> None:
    """Append data completely or not at all; raises OSError.

    A partial row, or a partial record, would spoil everything after it.
    """
    size = os.fstat(fd).st_size
    try:
        while data:
            data = data[os.write(fd, data) :]
    except OSError:
        with suppress(OSError):
            os.ftruncate(fd, size)
        raise


def numbered_files(path: str | Path) -> list[tuple[int, Path]]:
    """Return the files ``NAME-1.csv``, ``NAME-2.csv``, … in the folder of ``NAME.csv``, with their numbers."""
    path = Path(path)
    pattern = re.compile(rf"{re.escape(path.stem)}-(\d{{1,9}}){re.escape(path.suffix)}", re.ASCII)
    with suppress(OSError):
        found = [(pattern.fullmatch(each.name), each) for each in path.parent.iterdir()]
        return sorted((int(match[1]), each) for match, each in found if match)
    return []


def next_number(path: Path) -> int:
    """Return the highest number of the files ``NAME-N`` plus one; ``NAME`` itself counts as number 1."""
    return 1 + max((number for number, _ in numbered_files(path)), default=int(path.exists()))


def read_file(path: str | Path) -> bytes:
    """Return the content of a regular file; raises OSError, also for anything that would block, such as a pipe."""
    if not stat.S_ISREG(os.stat(path).st_mode):
        if Path(path).is_dir():
            raise OSError(errno.EISDIR, os.strerror(errno.EISDIR))
        raise OSError(errno.EINVAL, "this is no file")
    return Path(path).read_bytes()
