"""Files of a recording: locked while they are written, written whole or not at all, and numbered."""

from __future__ import annotations

import errno
import os
import re
import stat
from contextlib import suppress
from pathlib import Path


def lock(fd: int) -> bool:
    """Show that this file is being written; the lock ends with its process. False: somebody else writes it."""
    try:
        import fcntl

        fcntl.flock(fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except (ImportError, OSError):
        return True  # a system or a file system without these locks
    return True


def is_written(path: Path) -> bool:
    """Whether a process writes a segment now; raises OSError."""
    fd = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    try:
        return not lock(fd)
    finally:
        os.close(fd)


def still_there(path: Path, fd: int) -> None:
    """Raises OSError when this open file does not stand at its path any more: what is written to it is lost."""
    found, own = os.stat(path), os.fstat(fd)
    if (found.st_dev, found.st_ino) != (own.st_dev, own.st_ino):
        raise OSError(errno.ENOENT, "another file is in its place")


def append_whole(fd: int, data: bytes) -> None:
    """All or nothing, raises OSError: a piece of a row, or of a record, would spoil whatever follows."""
    size = os.fstat(fd).st_size
    try:
        while data:
            data = data[os.write(fd, data) :]
    except OSError:
        with suppress(OSError):
            os.ftruncate(fd, size)
        raise


def numbered_files(path: str | Path) -> list[tuple[int, Path]]:
    """The files ``NAME-1.csv``, ``NAME-2.csv``, … that stand beside a file ``NAME.csv``, with their numbers."""
    path = Path(path)
    pattern = re.compile(rf"{re.escape(path.stem)}-(\d{{1,9}}){re.escape(path.suffix)}", re.ASCII)
    with suppress(OSError):
        found = [(pattern.fullmatch(each.name), each) for each in path.parent.iterdir()]
        return sorted((int(match[1]), each) for match, each in found if match)
    return []


def next_number(path: Path) -> int:
    """One more than the highest number of ``NAME-N`` beside ``NAME``, which is number 1 itself."""
    return 1 + max((number for number, _ in numbered_files(path)), default=int(path.exists()))


def read_file(path: str | Path) -> bytes:
    """All of a regular file; raises OSError, also for what would be waited for, such as a pipe."""
    if not stat.S_ISREG(os.stat(path).st_mode):
        if Path(path).is_dir():
            raise OSError(errno.EISDIR, os.strerror(errno.EISDIR))
        raise OSError(errno.EINVAL, "this is no file")
    return Path(path).read_bytes()
