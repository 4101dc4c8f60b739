"""ROS bag 1, chunk by chunk; a file without its index, as a killed recorder leaves it, from the front."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

from rosbags.rosbag1 import Reader
from rosbags.rosbag1.reader import Header, RecordType, normalize, read_bytes, read_uint32

from end_effector_hal.errors import UsageError

from ._bag_message import ROS1, BagMessage, reason_of
from ._unpack import unpack

MAGIC = b"#ROSBAG V2.0\n"


class Connection(NamedTuple):
    """A publisher: its topic, type, and what the fields of that are."""

    topic: str
    type: str
    definition: str


class Rosbag1:
    """A ``.bag`` file; raises UsageError for another version of the format."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.faults: list[str] = []
        self._connections: dict[int, Connection] = {}
        with path.open("rb") as file:
            found = file.readline(80)
        if found != MAGIC:
            raise UsageError(f"Only bags that begin with {MAGIC.decode().strip()} are read.", where=str(path))
        self._places = self._indexed()

    def _indexed(self) -> list[int] | None:
        """Where the chunks begin, by the index at the end; None: it is not there, or is damaged."""
        reader: Any = Reader(self._path)
        reader.read_index_data = lambda *_: None  # an entry for each message would fill the memory
        try:
            reader.open()
        except Exception:  # noqa: BLE001 the library raises anything for bytes that are no records
            return None
        for each in reader.connections:
            self._connections[each.id] = Connection(each.topic, each.msgtype, each.msgdef.data)
        places = sorted(info.pos for info in reader.chunk_infos)
        reader.close()
        return places

    def close(self) -> None:
        """Nothing: the file is open only while it is read."""

    def topics(self) -> dict[str, str]:
        """Each topic and its type: from the index, or else from the whole file."""
        if self._places is None:
            for _ in self._messages():
                pass
        return {each.topic: each.type for each in self._connections.values()}

    def messages(self, topics: frozenset[str]) -> Iterator[BagMessage]:
        """The messages of these topics, in the order of the file."""
        self.faults.clear()  # of the search for topics: they are met again
        for connection, at, content in self._messages():
            if connection.topic in topics:
                yield BagMessage(connection.topic, connection.type, at, content, connection.definition, ROS1)

    def _messages(self) -> Iterator[tuple[Connection, int, bytes]]:
        if self._places is None:
            what = "it has no index: it was not closed, or was cut off, and its end may be lost"
            self.faults.append(f"{self._path}: {what}; `rosbag reindex` may find more.")
        lost, reason = 0, ""
        for chunk in self._chunks():
            try:
                yield from self._within(chunk())
            except Exception as error:  # noqa: BLE001 and decompressors raise what they like
                lost, reason = lost + 1, reason_of(error)
        if lost:
            self.faults.append(f"{self._path}: {lost} chunks cannot be read to their end ({reason}).")

    def _chunks(self) -> Iterator[Any]:
        """For each chunk a function that gives its records."""
        size = self._path.stat().st_size
        with self._path.open("rb") as file:

            def chunk() -> bytes:
                header = Header.read(file, RecordType.CHUNK)
                data = file.read(min(read_uint32(file), size))
                return unpack(header.get_string("compression"), data)

            for place in self._places or ():
                file.seek(place)
                yield chunk
            if self._places is not None:
                return
            file.seek(len(MAGIC))
            # whatever breaks this loop is the end of what can be read, and has been told
            with suppress(Exception):
                while (place := file.tell()) < size:
                    header = Header.read(file)
                    end = read_uint32(file) + file.tell()
                    if header.get_uint8("op") == RecordType.CHUNK:
                        file.seek(place)
                        yield chunk
                    file.seek(end)

    def _within(self, data: bytes) -> Iterator[tuple[Connection, int, bytes]]:
        records = BytesIO(data)
        while records.tell() < len(data):
            header = Header.read(records)
            op = header.get_uint8("op")
            if op == RecordType.CONNECTION:
                number, topic = header.get_uint32("conn"), normalize(header.get_string("topic"))
                about = Header.read(records)
                found = Connection(topic, about.get_string("type"), about.get_string("message_definition"))
                self._connections.setdefault(number, found)
                continue
            content = read_bytes(records, read_uint32(records))
            if op == RecordType.MSGDATA:
                connection = self._connections.get(header.get_uint32("conn"))
                if connection is not None:
                    yield connection, header.get_time("time") // 1000, content
