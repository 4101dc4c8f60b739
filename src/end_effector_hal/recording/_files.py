"""The files of a recording: locks while they are written, all-or-nothing writes, numbers, and limits of their size.

Files are cut into segments, and the oldest segments are removed first.
"""

from __future__ import annotations

import errno
import logging
import os
import re
import stat
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from end_effector_hal.errors import UsageError
from end_effector_hal.owned import open_owned


class RunFile:
    """Names of the files of a recording, beside its traces."""

    INFO = "run.json"
    STATES = "states.csv"
    EVENTS = "events.csv"
    PRESSURES = "pressures.csv"
    SWITCHES = "switches.csv"
    CHANGER = "tool_changer.csv"
    PARTS = "parts.csv"
    ALARMS = "alarms.csv"


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


_log = logging.getLogger("end_effector_hal.recording")
MEGABYTE = 1_000_000
REMOVED = "removed.csv"
LEAST_SEGMENTS = 7
"""Six files, a trace and five tables, are written at once, and one older segment must remain."""
_SEGMENT = re.compile(
    r"hal(?:-(?P<number>\d{1,9}))?\.mcap|(?:states|events|pressures|switches|alarms)(?P<closed>-\d{1,9})?\.csv",
    re.ASCII,
)


@dataclass(frozen=True, slots=True)
class RecordingLimits:
    """Limits of one recording folder.

    Args:
        segment_bytes: size at which a file is closed and the next segment begins.
        total_bytes: maximum size of all segments of the folder; when a segment begins, the oldest closed ones are
            removed.

    Raises:
        UsageError: a limit is not positive, or the total has no room for seven segments.
    """

    segment_bytes: int = 64 * MEGABYTE
    total_bytes: int = 1000 * MEGABYTE

    def __post_init__(self) -> None:
        if not 0 < self.segment_bytes <= self.total_bytes // LEAST_SEGMENTS:
            what = f"A recording cannot be kept in {_mb(self.total_bytes)} with segments of {_mb(self.segment_bytes)}."
            raise UsageError(what, todo=f"Keep at least {LEAST_SEGMENTS} segments of a positive size.")

    @classmethod
    def of_megabytes(cls, segment_mb: float, keep_mb: float) -> RecordingLimits:
        """Return limits from megabytes, the unit of the command line; raises UsageError."""
        most = 1e9
        if not (0 < segment_mb < most and 0 < keep_mb < most):  # not a number compares false, too
            raise UsageError(f"The limits of a recording are megabytes, not {segment_mb:g} and {keep_mb:g}.")
        return cls(round(segment_mb * MEGABYTE), round(keep_mb * MEGABYTE))


def make_room(folder: Path, limits: RecordingLimits) -> tuple[str, ...]:
    """Remove the oldest closed segments until one more fits into the folder; return their names.

    They are also listed in ``removed.csv``.

    A file that a process is writing (it is locked) is never removed, and counts with the full size of a segment.

    Raises:
        OSError: the folder cannot be read.
    """
    closed: list[tuple[int, int, int, Path]] = []
    taken = limits.segment_bytes
    for path in folder.iterdir():
        match = _SEGMENT.fullmatch(path.name)
        if match is None:
            continue
        with suppress(OSError):  # another writer has removed it
            found = path.stat()
            written = is_written(path) or (path.suffix == ".csv" and match["closed"] is None)
            taken += max(found.st_size, limits.segment_bytes) if written else found.st_size
            if not written:
                # the number decides for two that were closed at the same time
                number = int(match["number"] or (match["closed"] or "-1")[1:])
                closed.append((found.st_mtime_ns, number, found.st_size, path))
    removed: list[str] = []
    for _, _, size, path in sorted(closed):
        if taken <= limits.total_bytes:
            break
        with suppress(OSError):
            path.unlink()
            removed.append(path.name)
            _note(folder, path.name, size)
        taken -= size
    return tuple(removed)


def _note(folder: Path, name: str, size: int) -> None:
    path = folder / REMOVED
    row = f"{datetime.now(UTC).isoformat(timespec='seconds')},{name},{size}\n"
    try:
        text = row if path.exists() else f"time,file,bytes\n{row}"
        fd = open_owned(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
        try:
            os.write(fd, text.encode())
        finally:
            os.close(fd)
    except OSError as error:
        _log.warning("%s: the removal of %s cannot be noted: %s", path, name, error.strerror)


def _mb(count: int) -> str:
    return f"{count / MEGABYTE:g} MB"
