"""Read a trace: all records that reached the disk, even if the program did not end normally."""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from io import BytesIO
from operator import itemgetter
from pathlib import Path
from typing import Any

from end_effector_hal.errors import UsageError, os_errors

from ._files import read_file
from ._segment import MAGIC

DATA_END_BYTES = 13
"""Size of the record DATA_END, bytes: opcode, length, checksum."""
FOOTER_BYTES = 29
"""Size of the footer, bytes: opcode, length, offsets of the summary and of its index, checksum."""
CHECKSUM_BYTES = 4
CHUNK_HEAD = struct.Struct("<BQQQQIIQ")
"""Opcode and length; first and last time, size, checksum, length of the compression's name, which is empty; length of
the records.
"""
NO_CHECKSUM = 0
_COMPRESSED = "records are compressed, as in no trace; `mcap decompress` decompresses a file"
"""The message for a compressed file, which is refused because a few bytes may expand to gigabytes."""


@dataclass(frozen=True, slots=True)
class Record:
    """One record: its kind, and its content as it was written.

    Attributes:
        kind: the last part of its topic.
        data: the content as JSON.
        day_us: time of day of its message, µs; None: the record was not read from a file.
    """

    kind: str
    data: bytes
    day_us: int | None = None

    @property
    def content(self) -> dict[str, Any]:
        """Return the content as a JSON object; raises ValueError if it is not an object."""
        try:
            found = json.loads(self.data)
        except RecursionError:
            raise ValueError("it is nested too deep") from None
        if not isinstance(found, dict):
            raise ValueError(f"not an object: {found!r}"[:60])
        return found


@dataclass(frozen=True, slots=True)
class TraceFile:
    """The content of a trace, in the order of writing.

    Attributes:
        path: path of the file.
        records: all records.
        attachments: files that belong to the run.
        complete: whether the file was closed normally; if not, ``note`` states where it ends.
        damaged: whether the checksum or the format shows that bytes were changed; ``note`` reports it. Only a closed
            file has a checksum.
        size: size of the file, bytes.
    """

    path: Path
    records: tuple[Record, ...]
    attachments: Mapping[str, bytes]
    complete: bool
    note: str = ""
    damaged: bool = False
    size: int = 0


def read_trace(path: str | Path) -> TraceFile:
    """Read a trace; a truncated file is read up to its end.

    Raises:
        UsageError: the file cannot be read, or is no MCAP file.
    """
    path = Path(path)
    from mcap.records import Attachment, Channel, DataEnd, Footer, Message

    with os_errors("Cannot be read", path):
        data = read_file(path)
    if data[: len(MAGIC)] != MAGIC[: len(data)]:
        raise UsageError("This is not an MCAP file.", where=str(path))
    topics: dict[int, str] = {}
    numbered: list[tuple[int, Record]] = []
    attachments: dict[str, bytes] = {}
    complete, note = False, "it was not closed: the program was killed or still writes, or its disk was full"
    changed = True  # until the record that carries the checksum says otherwise
    reading = _Reading(data)
    for record in reading:
        if isinstance(record, Channel):
            topics[record.id] = record.topic
        elif isinstance(record, Attachment):
            attachments[record.name] = record.data
        elif isinstance(record, Message) and record.channel_id in topics:
            kind = topics[record.channel_id].rpartition("/")[2]
            numbered.append((record.sequence, Record(kind, record.data, record.log_time // 1000)))
        elif isinstance(record, DataEnd):
            changed = reading.changed(0, DATA_END_BYTES, record.data_section_crc)
        elif isinstance(record, Footer):
            complete, note = True, ""
            begin = record.summary_start or reading.place - FOOTER_BYTES
            changed = changed or reading.changed(begin, CHECKSUM_BYTES, record.summary_crc)
    changed = complete and changed
    note = reading.note or ("bytes in it were changed since it was written" if changed else note)
    damaged = changed or bool(reading.note)
    return TraceFile(path, _in_order(numbered), attachments, complete, note, damaged, len(data))


def _in_order(numbered: list[tuple[int, Record]]) -> tuple[Record, ...]:
    """Return the records in the order of writing, up to the first missing one."""
    numbered.sort(key=itemgetter(0))
    gap = (at for at, (number, _) in enumerate(numbered) if number != at + 1)
    return tuple(record for _, record in numbered[: next(gap, None)])


class _Reading:
    """The records of a file up to its end, or up to the first unreadable place."""

    def __init__(self, data: bytes) -> None:
        self._file, self._size, self._data, self.note = BytesIO(data), len(data), data, ""

    def __iter__(self) -> Iterator[object]:
        from mcap.exceptions import EndOfFile, RecordLengthLimitExceeded
        from mcap.records import Chunk
        from mcap.stream_reader import StreamReader, breakup_chunk

        begin = len(MAGIC)
        try:
            for record in StreamReader(self._file, emit_chunks=True, record_size_limit=self._size).records:
                begin = self._file.tell()
                if not isinstance(record, Chunk):
                    yield record
                elif record.compression:
                    raise ValueError(_COMPRESSED)
                else:
                    yield from breakup_chunk(record)
        except (EndOfFile, struct.error, RecordLengthLimitExceeded):
            if self._data[len(MAGIC) :].endswith(MAGIC):  # it was closed: else it was cut off within a record
                self.note = f"near byte {self._file.tell()} a record is longer than the file"
            else:
                yield from self._cut_off(begin)
        except Exception as error:  # noqa: BLE001 - damaged records raise whatever the library raises
            self.note = f"near byte {self._file.tell()}: {error or type(error).__name__}"

    def _cut_off(self, begin: int) -> Iterator[object]:
        """Yield the whole records of a truncated chunk that begins at ``begin``."""
        from mcap.opcode import Opcode
        from mcap.stream_reader import StreamReader

        head = self._data[begin : begin + CHUNK_HEAD.size]
        if len(head) < CHUNK_HEAD.size:
            return
        opcode, *_, compression_bytes, _ = CHUNK_HEAD.unpack(head)
        if opcode != Opcode.CHUNK or compression_bytes:
            return
        inside = BytesIO(self._data[begin + CHUNK_HEAD.size :])
        with suppress(Exception):  # to its end, which is missing
            yield from StreamReader(inside, skip_magic=True, record_size_limit=self._size).records

    @property
    def place(self) -> int:
        """Number of bytes of the file that have been read."""
        return self._file.tell()

    def changed(self, start: int, after: int, checksum: int) -> bool:
        """Return whether the bytes from ``start`` to ``after`` bytes before the position differ from the checksum."""
        summed = self._data[start : self._file.tell() - after]
        return checksum != NO_CHECKSUM and zlib.crc32(summed) != checksum
