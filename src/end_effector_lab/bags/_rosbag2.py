"""rosbag2 as the library reads it: SQLite, and what is compressed message by message or file by file."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rosbags.interfaces import MessageDefinitionFormat
from rosbags.rosbag2 import Reader

from end_effector_hal.errors import UsageError

from ._bag_message import IDL, MSG, BagMessage, reason_of
from ._unpack import unpack

_SYNTAX = {MessageDefinitionFormat.MSG: MSG, MessageDefinitionFormat.IDL: IDL}


class Rosbag2:
    """Folders with a ``metadata.yaml``, or ``.db3`` files; raises UsageError when one cannot be opened."""

    def __init__(self, paths: tuple[Path, ...]) -> None:
        self._readers: list[tuple[Path, Any]] = []
        self._packed: set[Path] = set()
        self.faults: list[str] = []
        for path in paths:
            try:
                reader = Reader(path)
                reader.open()
            except Exception as error:  # noqa: BLE001 the library raises anything for what is no bag
                if len(paths) == 1:
                    what = f"The bag cannot be read: {reason_of(error)}."
                    raise UsageError(what, where=str(path)) from None
                self.faults.append(f"{path} cannot be read: {reason_of(error)}.")
            else:
                self._readers.append((path, reader))
                if reader.compression_mode == "message":
                    # the library would unpack without a limit
                    reader.storage.metadata = reader.storage.metadata._replace(compression_mode=None)
                    self._packed.add(path)
            self.faults += [
                f"{log} holds messages that its database has not: the recorder was killed. Open it once with "
                f"`sqlite3 {log.with_name(log.name[:-4])} .tables`."
                for log in (
                    path.rglob("*.db3-wal") if path.is_dir() else path.parent.glob(f"{path.name}-wal")
                )
                if log.stat().st_size
            ]

    def close(self) -> None:
        """Close the files."""
        for _, reader in self._readers:
            reader.close()

    def topics(self) -> dict[str, str]:
        """Each topic and its type."""
        return {
            each.topic: each.msgtype
            for _, reader in self._readers
            for each in reader.connections
            if isinstance(each.topic, str) and isinstance(each.msgtype, str)  # a column holds anything
        }

    def messages(self, topics: frozenset[str]) -> Iterator[BagMessage]:
        """The messages of these topics, in the order of the time at which they came."""
        for path, reader in self._readers:
            wanted = [each for each in reader.connections if each.topic in topics]
            try:
                for one, at, data in reader.messages(wanted) if wanted else ():
                    syntax = _SYNTAX.get(one.msgdef.format, "")
                    data = unpack("zstd", data) if path in self._packed else data
                    yield BagMessage(one.topic, one.msgtype, at // 1000, data, one.msgdef.data, syntax)
            except Exception as error:  # noqa: BLE001 as above, and bytes that cannot be unpacked
                self.faults.append(f"{path}: what follows is lost ({reason_of(error)}).")
