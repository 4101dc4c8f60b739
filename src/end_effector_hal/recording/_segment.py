"""Write one file of a trace: create it, append batches of records, and close it with its checksum."""

from __future__ import annotations

import errno
import json
import os
import struct
import zlib
from collections.abc import Mapping
from contextlib import suppress
from functools import cache
from pathlib import Path
from time import time_ns
from typing import Any

from pydantic import TypeAdapter
from pydantic_core import to_json

from end_effector_hal.errors import UsageError

from ._files import MEGABYTE, append_whole, lock, next_number, still_there

MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, SCHEMA, CHANNEL, MESSAGE, ATTACHMENT, DATA_END = 0x01, 0x02, 0x03, 0x04, 0x05, 0x09, 0x0F
"""Opcodes of https://mcap.dev/spec. Only indexing and reading need the library `mcap`; a robot that only writes traces
does not install it, because it depends on 29 MB of compression libraries.
"""
_MESSAGE = struct.Struct("<HIQQ")
"""Head of a message: channel, number, time of the record, time of publication."""
NAME, SUFFIX = "hal", ".mcap"
"""Name of the files, and first part of their topics."""
LEAST_ROOM = MEGABYTE // 2
"""Free disk space needed to begin a file, bytes; a file begun with less would soon fill the disk."""


class SegmentFile:
    """Writes one MCAP file; every record can be read alone, and only whole batches reach the file.

    Args:
        folder: created if it is missing; the file gets the next free number.
        kinds: name of each kind of record, and the dataclass of its content.
        attachments: name and content of files that belong to the run.
        day_us: offset from a record's time to the time of day, µs.

    Raises:
        UsageError: the path is not a folder.
        OSError: the file cannot be created, or the disk has no room for it; no file is left behind.
    """

    def __init__(
        self, folder: Path, kinds: Mapping[str, type], *, attachments: Mapping[str, bytes], day_us: int
    ) -> None:
        self.path, self._fd = _create(folder)
        self.size = 0
        """Number of bytes written."""
        self._day_us, self._count = day_us, 0
        self._waiting, self._checksum = bytearray(), 0
        self._channels = {kind: number for number, kind in enumerate(kinds, start=1)}
        try:
            lock(self._fd)
            _ask_room(self._fd)
            self._append(_beginning(kinds, attachments))
            self.write()
        except BaseException:
            self.discard()
            raise

    def add(self, kind: str, at: int, content: object) -> None:
        """Add a record with its time ``at``, µs on the monotonic clock; :meth:`write` writes it to the file."""
        time = (at + self._day_us) * 1000
        self._count += 1  # times may go back: the number has the order
        head = _MESSAGE.pack(self._channels[kind], self._count, time, time)
        self._append(_record(MESSAGE, head, to_json(content, fallback=_plain)))

    def _append(self, data: bytes) -> None:
        self._checksum = zlib.crc32(data, self._checksum)
        self._waiting += data

    def write(self) -> None:
        """Write the added records, all or none; raises OSError."""
        data = bytes(self._waiting)
        self._waiting.clear()
        still_there(self.path, self._fd)
        append_whole(self._fd, data)
        self.size += len(data)

    def finish(self) -> None:
        """Write the checksum of all records and close the file; raises OSError, but closes the file even then."""
        footer = struct.pack("<BQQQ", FOOTER, 20, 0, 0)  # no summary: it comes with the index
        try:
            self._append(_record(DATA_END, self._checksum.to_bytes(4, "little")))
            self._append(footer + zlib.crc32(footer).to_bytes(4, "little") + MAGIC)
            self.write()
        finally:
            self.leave()

    def leave(self) -> None:
        """Close the file without its checksum; may be called again."""
        fd, self._fd = self._fd, -1
        if fd >= 0:
            with suppress(OSError):
                os.close(fd)

    def discard(self) -> None:
        """Close the file and remove it, because it contains no records."""
        with suppress(OSError):
            self.path.unlink()
        self.leave()


def _beginning(kinds: Mapping[str, type], attachments: Mapping[str, bytes]) -> bytes:
    """Return the start of the file: the files of the run, and a schema and a channel for each kind of record."""
    records = [MAGIC, _record(HEADER, _counted(""), _counted("end-effector-hal"))]
    for name, content in attachments.items():
        media = "application/json" if name.endswith(".json") else "application/xml"
        times = struct.pack("<QQ", time_ns(), time_ns())
        inside = b"".join((times, _counted(name), _counted(media), struct.pack("<Q", len(content)), content))
        records.append(_record(ATTACHMENT, inside, zlib.crc32(inside).to_bytes(4, "little")))
    for number, (kind, type_) in enumerate(kinds.items(), start=1):
        name = f"end_effector_hal.{type_.__name__}"
        schema = (_counted(name), _counted("jsonschema"), _counted(_schema(type_)))
        records.append(_record(SCHEMA, struct.pack("<H", number), *schema))
        channel = (_counted(f"/{NAME}/{kind}"), _counted("json"), _counted(""))
        records.append(_record(CHANNEL, struct.pack("<HH", number, number), *channel))
    return b"".join(records)


def _record(opcode: int, *parts: bytes) -> bytes:
    return b"".join((struct.pack("<BQ", opcode, sum(map(len, parts))), *parts))


def _counted(text: str | bytes) -> bytes:
    """Return a text or bytes, preceded by the number of bytes."""
    data = text.encode() if isinstance(text, str) else text
    return struct.pack("<I", len(data)) + data


@cache
def _schema(kind: type) -> bytes:
    return json.dumps(plain_schema(kind)).encode()


def _ask_room(fd: int) -> None:
    found = os.fstatvfs(fd)
    if found.f_blocks and found.f_bavail * found.f_frsize < LEAST_ROOM:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def _plain(value: object) -> object:
    return dict(value) if isinstance(value, Mapping) else str(value)


def _create(folder: Path) -> tuple[Path, int]:
    if folder.exists() and not folder.is_dir():
        raise UsageError("This is not a folder.", where=str(folder))
    folder.mkdir(parents=True, exist_ok=True)
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND | os.O_CLOEXEC
    first = folder / f"{NAME}{SUFFIX}"
    number = next_number(first)
    while True:
        path = first if number == 1 else first.with_stem(f"{NAME}-{number}")
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
