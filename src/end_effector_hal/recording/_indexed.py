"""Rewrite a closed segment sorted by time, in chunks, with an index, as other MCAP programs expect.

While a program runs, records are appended as they happen, and their times may go back a little. The number of each
record keeps the order of writing, in which `read_trace` returns them.
"""

from __future__ import annotations

import os
import sys
import threading
import time
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from subprocess import DEVNULL, Popen
from typing import IO

from ._files import MEGABYTE, lock, still_there

CHUNK_BYTES = 64 * 1024
"""Size of a chunk, bytes; a file that is cut off later loses at most one chunk in addition to the cut part."""
NAME = ".{}.indexed"
_PROGRAM = (
    f"import os, sys, pathlib, {__name__} as i; os.nice(19); i.write_indexed(pathlib.Path(sys.argv[1]))"
)


class TooLongError(Exception):
    """The indexing took longer than allowed."""


def write_indexed(path: Path, until: float | None = None) -> None:
    """Replace a closed segment by its indexed form, in one step; after a failure the segment is unchanged.

    Args:
        path: the segment; free disk space of the same size is needed for a moment.
        until: time at which the indexing is abandoned, on the monotonic clock of `time`, s; None: never.

    Raises:
        ModuleNotFoundError: the extra `recordings` is not installed; another program may index the file.
        OSError: the disk failed, another process uses the segment, or the segment was removed.
        TooLongError: the indexing was abandoned.
        ValueError: the segment is damaged.
    """
    beside = path.with_name(NAME.format(path.name))
    flags = os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC
    with path.open("rb") as source, os.fdopen(os.open(beside, flags, 0o644), "r+b") as target:
        if not lock(target.fileno()):
            raise BlockingIOError(f"another process writes {beside}")
        try:
            target.truncate()
            found, room = os.fstat(source.fileno()), os.fstatvfs(target.fileno())
            if room.f_bavail * room.f_frsize < 2 * found.st_size + MEGABYTE:
                raise OSError("the disk has no room for its indexed form")
            if _copy(source, target, until):
                target.flush()
                os.fsync(target.fileno())
                # the oldest segments are removed first
                os.utime(target.fileno(), ns=(found.st_atime_ns, found.st_mtime_ns))
                still_there(path, source.fileno())
                beside.replace(path)
        finally:
            with suppress(OSError):
                beside.unlink()


def _copy(source: IO[bytes], target: IO[bytes], until: float | None) -> bool:
    """Write the records in order of time; return False if the file has chunks already.

    Schemas and channels keep their numbers.
    """
    from mcap.data_stream import ReadDataStream
    from mcap.records import Attachment, Channel, Chunk, DataEnd, Header, Message, Schema
    from mcap.stream_reader import StreamReader
    from mcap.writer import CompressionType, Writer

    writer = Writer(target, CHUNK_BYTES, CompressionType.NONE, enable_data_crcs=True)
    places: list[tuple[int, int]] = []
    begin = 0
    for record in StreamReader(source, emit_chunks=True, validate_crcs=True).records:
        if isinstance(record, Message):
            places.append((record.log_time, begin))
        elif isinstance(record, Header):
            writer.start(record.profile, record.library)
        elif isinstance(record, Attachment):
            times = record.create_time, record.log_time
            writer.add_attachment(*times, record.name, record.media_type, record.data)
        elif isinstance(record, Schema):
            writer.register_schema(record.name, record.encoding, record.data)
        elif isinstance(record, Channel):
            writer.register_channel(record.topic, record.message_encoding, record.schema_id, record.metadata)
        elif isinstance(record, Chunk):
            return False
        elif isinstance(record, DataEnd):
            break
        begin = source.tell()
        _check(until)
    for _, place in sorted(places):
        source.seek(place + 1)
        stream = ReadDataStream(source)
        each = Message.read(stream, stream.read8())
        writer.add_message(each.channel_id, each.log_time, each.data, each.publish_time, each.sequence)
        _check(until)
    writer.finish()  # type: ignore[no-untyped-call]
    return True


def _check(until: float | None) -> None:
    if until is not None and time.monotonic() > until:
        raise TooLongError


def start_indexing(path: Path) -> None:
    """Start a process that indexes a segment and continues after the end of this process.

    Raises:
        ModuleNotFoundError: the extra `recordings` is not installed.
        OSError: the process cannot be started.
    """
    import_module("mcap.writer")  # else the process would fail without a word
    child = Popen(
        [sys.executable, "-c", _PROGRAM, path], 0, None, DEVNULL, DEVNULL, DEVNULL, start_new_session=True
    )
    threading.Thread(target=child.wait, name="trace-indexing", daemon=True).start()


def remove_leftovers(folder: Path) -> None:
    """Remove temporary files that a killed indexing process has left."""
    for path in folder.glob(NAME.format("*.mcap")):
        with suppress(OSError), path.open("rb") as file:
            if lock(file.fileno()):
                path.unlink()
