"""rosbag of ROS 1, chunk by chunk."""

from __future__ import annotations

from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any

from rosbags.rosbag1 import Reader
from rosbags.rosbag1.reader import Header, RecordType, read_bytes, read_uint32

from end_effector_hal.errors import UsageError

from ._bag_message import ROS1, BagMessage, reason_of

NO_INDEX = ("not indexed", "index looks damaged", "Could not read", "Got only")
"""What the library says of a file that was not closed, or was cut off."""


class Rosbag1:
    """A ``.bag`` file; raises UsageError when it cannot be opened."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._reader: Any = Reader(path)
        # an entry for each message would fill the memory; here the chunks are read in their order
        self._reader.read_index_data = lambda *_: None
        self.faults: list[str] = []
        try:
            self._reader.open()
        except Exception as error:  # noqa: BLE001 the library raises anything for bytes that are no records
            if any(each in str(error) for each in NO_INDEX):
                todo = f"Run `rosbag reindex {path}`, and import it then."
                what = "The bag has no index: it was not closed, or was cut off."
                raise UsageError(what, where=str(path), todo=todo) from None
            raise UsageError(f"The bag cannot be read: {reason_of(error)}.", where=str(path)) from None

    def close(self) -> None:
        """Close the file."""
        self._reader.close()

    def topics(self) -> dict[str, str]:
        """Each topic and its type."""
        return {each.topic: each.msgtype for each in self._reader.connections}

    def messages(self, topics: frozenset[str]) -> Iterator[BagMessage]:
        """The messages of these topics, in the order of the file."""
        wanted = {each.id: each for each in self._reader.connections if each.topic in topics}
        lost = 0
        for info in sorted(self._reader.chunk_infos, key=lambda info: info.pos):
            if wanted.keys() & info.connection_counts.keys():
                try:
                    yield from self._chunk(self._reader.chunks[info.pos], wanted)
                except Exception as error:  # noqa: BLE001 and so do the decompressors
                    lost += 1
                    reason = reason_of(error)
        if lost:
            self.faults.append(f"{self._path}: {lost} chunks cannot be read to their end ({reason}).")

    def _chunk(self, chunk: Any, wanted: dict[int, Any]) -> Iterator[BagMessage]:
        file = self._reader.bio
        file.seek(chunk.datapos)
        data = chunk.decompressor(read_bytes(file, chunk.datasize))
        records = BytesIO(data)
        while records.tell() < len(data):
            header = Header.read(records)
            content = read_bytes(records, read_uint32(records))
            if header.get_uint8("op") == RecordType.MSGDATA and (
                one := wanted.get(header.get_uint32("conn"))
            ):
                at = header.get_time("time") // 1000
                yield BagMessage(one.topic, one.msgtype, at, content, one.msgdef.data, ROS1)
