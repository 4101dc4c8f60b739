"""MCAP, read from the front: a file that was cut off is read up to there, and no index is needed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import BinaryIO

from mcap.reader import make_reader
from mcap.records import Channel, Chunk, Message, Schema
from mcap.stream_reader import StreamReader, breakup_chunk

from end_effector_hal.errors import os_errors

from ._bag_message import BagMessage, reason_of
from ._unpack import unpack

_CUT = "what follows is lost: it was not closed, or bytes in it were changed"


class McapBag:
    """One or several files, in the order of writing."""

    def __init__(self, files: tuple[Path, ...]) -> None:
        self._files = files
        self.faults: list[str] = []

    def close(self) -> None:
        """Nothing: each file is open only while it is read."""

    def topics(self) -> dict[str, str]:
        """Each topic and its type: from the summary at the end, or else from the whole file."""
        found: dict[str, str] = {}
        for path in self._files:
            with _opened(path) as file:
                found.update(_summary(file) or self._scanned(path, file))
        return found

    def messages(self, topics: frozenset[str]) -> Iterator[BagMessage]:
        """The messages of these topics, in the order of the files."""
        self.faults.clear()  # of the search for topics: they are met again
        for path in self._files:
            schemas: dict[int, Schema] = {}
            channels: dict[int, Channel] = {}
            with _opened(path) as file:
                for record in self._records(path, file):
                    if isinstance(record, Schema):
                        schemas[record.id] = record
                    elif isinstance(record, Channel):
                        channels[record.id] = record
                    elif isinstance(record, Message):
                        channel = channels.get(record.channel_id)
                        if channel is not None and channel.topic in topics:
                            yield _message(record, channel, schemas.get(channel.schema_id))

    def _scanned(self, path: Path, file: BinaryIO) -> dict[str, str]:
        file.seek(0)
        types: dict[int, str] = {}
        found: dict[str, str] = {}
        for record in self._records(path, file):
            if isinstance(record, Schema):
                types[record.id] = record.name
            elif isinstance(record, Channel):
                found[record.topic] = types.get(record.schema_id, "")
        return found

    def _records(self, path: Path, file: BinaryIO) -> Iterator[object]:
        """All that can be read, in order; what cannot is told."""
        size = path.stat().st_size
        lost, reason = 0, ""
        try:
            for record in StreamReader(file, emit_chunks=True, record_size_limit=size).records:
                if not isinstance(record, Chunk):
                    yield record
                    continue
                try:
                    within = breakup_chunk(_unpacked(record), validate_crc=True)
                except Exception as error:  # noqa: BLE001 decompressors raise what they like
                    lost, reason = lost + 1, reason_of(error)
                else:
                    yield from within
        except Exception as error:  # noqa: BLE001 and the library for bytes that are no records
            self.faults.append(f"{path}: near byte {file.tell()} of {size} ({reason_of(error)}) {_CUT}.")
        if lost:
            self.faults.append(f"{path}: {lost} chunks cannot be read ({reason}).")


def _opened(path: Path) -> BinaryIO:
    with os_errors("Cannot be read", path):
        return path.open("rb")


def _unpacked(chunk: Chunk) -> Chunk:
    data = unpack(chunk.compression, chunk.data)
    if len(data) != chunk.uncompressed_size:
        raise ValueError(f"it unpacks to {len(data)} bytes instead of {chunk.uncompressed_size}")
    return replace(chunk, compression="", data=data)


def _summary(file: BinaryIO) -> dict[str, str]:
    try:
        summary = make_reader(file).get_summary()
    except Exception:  # noqa: BLE001 it is looked at from the front then
        return {}
    if summary is None:
        return {}
    types = {key: schema.name for key, schema in summary.schemas.items()}
    return {each.topic: types.get(each.schema_id, "") for each in summary.channels.values()}


def _message(record: Message, channel: Channel, schema: Schema | None) -> BagMessage:
    definition = schema.data.decode(errors="replace") if schema is not None else ""
    return BagMessage(
        channel.topic,
        schema.name if schema is not None else "",
        record.log_time // 1000,
        record.data,
        definition,
        schema.encoding if schema is not None else "",
    )
