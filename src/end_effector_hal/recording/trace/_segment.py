"""One file of a trace: created, written batch by batch, and closed with its checksum."""

from __future__ import annotations

import errno
import json
import os
from collections.abc import Mapping
from contextlib import suppress
from functools import cache
from io import BytesIO
from pathlib import Path
from time import time_ns
from typing import TYPE_CHECKING, Any

from pydantic import TypeAdapter
from pydantic_core import to_json

from end_effector_hal.errors import UsageError
from end_effector_hal.recording._files import append_whole, lock, next_number, still_there
from end_effector_hal.recording._limits import MEGABYTE

if TYPE_CHECKING:
    from mcap.writer import Writer


SUFFIX = ".mcap"
LEAST_ROOM = MEGABYTE // 2
"""Free disk space that is needed to begin a file, bytes; with less the file would be full at once."""


class SegmentFile:
    """An MCAP file that is being written; it always contains whole batches only.

    Args:
        folder: created if it is missing; the file gets the next free number of its program.
        program: the program whose trace it is; topics are ``program/kind``.
        kinds: name of each kind of record, and the dataclass of its content.
        attachments: name and content of files that belong to the run.
        day_us: offset from a record's time to the time of day, µs.

    Raises:
        UsageError: the path is not a folder.
        OSError: the file cannot be created, or the disk has no room for it; nothing is left behind.
    """

    def __init__(
        self,
        folder: Path,
        program: str,
        kinds: Mapping[str, type],
        *,
        attachments: Mapping[str, bytes],
        day_us: int,
    ) -> None:
        from mcap.writer import CompressionType, Writer

        self.path, self._fd = _create(folder, program)
        self.size = 0
        """Number of bytes written."""
        self._day_us, self._count = day_us, 0
        self._sink = _Sink()
        # without chunks: each record stands alone; a checksum of all of them comes last
        self._writer = Writer(
            self._sink, use_chunking=False, compression=CompressionType.NONE, enable_data_crcs=True
        )
        try:
            lock(self._fd)
            _ask_room(self._fd)
            self._channels = _begin(self._writer, program, kinds, attachments)
            self.write()
        except BaseException:
            self.discard()
            raise

    def add(self, kind: str, at: int, content: object) -> None:
        """Add a record of an event at ``at`` µs on the monotonic clock; :meth:`write` writes it to the file."""
        data = to_json(content, fallback=_plain)
        time = (at + self._day_us) * 1000
        self._count += 1  # times may go back: the number has the order
        self._writer.add_message(self._channels[kind], time, data, time, self._count)

    def write(self) -> None:
        """Write the added records, all or none; raises OSError."""
        data = self._sink.take()
        still_there(self.path, self._fd)
        append_whole(self._fd, data)
        self.size += len(data)

    def finish(self) -> None:
        """Write the index and the checksum, and close the file; it is closed even if this raises OSError."""
        try:
            self._writer.finish()  # type: ignore[no-untyped-call]
            self.write()
        finally:
            self.leave()

    def leave(self) -> None:
        """Close the file as it is, without its checksum; may be called again."""
        fd, self._fd = self._fd, -1
        if fd >= 0:
            with suppress(OSError):
                os.close(fd)

    def discard(self) -> None:
        """Close the file and remove it: it contains nothing."""
        with suppress(OSError):
            self.path.unlink()
        self.leave()


class _Sink(BytesIO):
    """The buffer that the MCAP library writes to; it discards bytes that were taken, but keeps the position."""

    _taken = 0

    def tell(self) -> int:
        return self._taken + super().tell()

    def take(self) -> bytes:
        data = self.getvalue()
        self._taken += len(data)
        self.seek(0)
        self.truncate()
        return data


def _begin(
    writer: Writer, program: str, kinds: Mapping[str, type], attachments: Mapping[str, bytes]
) -> dict[str, int]:
    writer.start(profile="", library="end-effector-hal")
    for name, content in attachments.items():
        media = "application/json" if name.endswith(".json") else "application/xml"
        writer.add_attachment(time_ns(), time_ns(), name, media, content)
    channels = {}
    for kind, type_ in kinds.items():
        schema = _schema(type_)
        number = writer.register_schema(f"end_effector_hal.{type_.__name__}", "jsonschema", schema)
        channels[kind] = writer.register_channel(f"/{program}/{kind}", "json", number)
    return channels


@cache
def _schema(kind: type) -> bytes:
    return json.dumps(plain_schema(kind)).encode()


def _ask_room(fd: int) -> None:
    found = os.fstatvfs(fd)
    if found.f_blocks and found.f_bavail * found.f_frsize < LEAST_ROOM:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def _plain(value: object) -> object:
    return dict(value) if isinstance(value, Mapping) else str(value)


def _create(folder: Path, program: str) -> tuple[Path, int]:
    if folder.exists() and not folder.is_dir():
        raise UsageError("This is not a folder.", where=str(folder))
    folder.mkdir(parents=True, exist_ok=True)
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND | os.O_CLOEXEC
    first = folder / f"{program}{SUFFIX}"
    number = next_number(first)
    while True:
        path = first if number == 1 else first.with_stem(f"{program}-{number}")
        try:
            return path, os.open(path, flags, 0o644)
        except FileExistsError:
            number += 1


def plain_schema(kind: type) -> dict[str, Any]:
    """Return the JSON schema of a dataclass without references."""
    schema = TypeAdapter(kind).json_schema()
    found = _without_references(schema, schema.get("$defs", {}))
    assert isinstance(found, dict)
    return found


def _without_references(schema: Any, known: Mapping[str, Any]) -> Any:
    if isinstance(schema, list):
        return [_without_references(item, known) for item in schema]
    if not isinstance(schema, dict):
        return schema
    if "$ref" in schema:
        return _without_references(known[schema["$ref"].rpartition("/")[2]], known)
    if "anyOf" in schema:
        first, *_ = [option for option in schema["anyOf"] if option.get("type") != "null"]
        return _without_references(first, known)
    left_out = ("$defs", "default", "prefixItems", "minItems", "maxItems")
    return {key: _without_references(value, known) for key, value in schema.items() if key not in left_out}
