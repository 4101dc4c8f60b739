"""Limit the size of a recording: its files are cut into segments, and the oldest segments are removed first."""

from __future__ import annotations

import logging
import os
import re
from contextlib import suppress
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from end_effector_hal.errors import UsageError
from end_effector_hal.owned import open_owned
from end_effector_hal.recording._files import is_written

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
