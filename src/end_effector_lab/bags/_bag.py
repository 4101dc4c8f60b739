"""Open a bag of ROS 1 or ROS 2 with the library `rosbags`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rosbags.interfaces import MessageDefinitionFormat
from rosbags.rosbag1 import Reader as Reader1
from rosbags.rosbag2 import Reader as Reader2

from end_effector_hal.errors import UsageError

from ._bag_message import IDL, MSG, ROS1, BagMessage, reason_of

_ROS1, _ROS2 = (".bag", ".active"), (".mcap", ".db3")
_WHAT = "Name a .bag file, a folder that rosbag2 wrote, or an .mcap file."
_SYNTAX = {MessageDefinitionFormat.MSG: MSG, MessageDefinitionFormat.IDL: IDL}


class Bag:
    """An open bag; closing it closes its files.

    Args:
        path: a ``.bag`` file of ROS 1, a folder of rosbag2, or one of its ``.mcap`` and ``.db3`` files.

    Raises:
        UsageError: there is no bag, or it is damaged; the message names the tool that repairs it.
    """

    def __init__(self, path: Path) -> None:
        if not path.exists():
            raise UsageError("There is no such bag.", where=str(path), todo=_WHAT)
        if path.is_file() and path.suffix not in (*_ROS1, *_ROS2):
            raise UsageError("This is not a bag.", where=str(path), todo=_WHAT)
        self._path = path
        self._ros1 = path.is_file() and path.suffix in _ROS1
        if not self._ros1:
            self._check_closed()
        with self._refusing_damage():
            self._reader = Reader1(path) if self._ros1 else Reader2(path)
            self._reader.open()

    def close(self) -> None:
        """Close the files."""
        self._reader.close()

    def topics(self) -> dict[str, str]:
        """Return each topic and its type."""
        return {
            each.topic: each.msgtype
            for each in self._reader.connections
            if isinstance(each.topic, str) and isinstance(each.msgtype, str)  # a column holds anything
        }

    def messages(self, topics: frozenset[str]) -> Iterator[BagMessage]:
        """Yield the messages of these topics, in the order in which they were written.

        Raises:
            UsageError: the rest of the bag is damaged.
        """
        wanted = [each for each in self._reader.connections if each.topic in topics]
        with self._refusing_damage():
            for one, at, data in self._reader.messages(wanted) if wanted else ():
                syntax = ROS1 if self._ros1 else _SYNTAX.get(one.msgdef.format, "")
                definition = one.msgdef.data
                yield BagMessage(one.topic, one.msgtype, at // 1000, data, definition, syntax)

    def _check_closed(self) -> None:
        """Refuse an incomplete bag of a killed ROS 2 recorder: the library would read less than the bag contains."""
        folder = self._path if self._path.is_dir() else self._path.parent
        if self._path.is_dir() and not (folder / "metadata.yaml").exists():
            if any(each.suffix in _ROS2 for each in folder.iterdir()):
                raise self._damaged("it has no metadata.yaml")
            raise UsageError("There is no bag in this folder.", where=str(self._path), todo=_WHAT)
        logs = folder.glob("*.db3-wal" if self._path.is_dir() else f"{self._path.name}-wal")
        for log in (each for each in logs if each.stat().st_size):
            raise self._damaged(f"{log.name} holds messages that its database does not hold")

    @contextmanager
    def _refusing_damage(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise UsageError(f"Cannot be read: {error.strerror or error}.", where=str(self._path)) from None
        except Exception as error:  # noqa: BLE001 the library raises anything for bytes that are no records
            if "Profile is not" in str(error):
                raise UsageError(
                    "This is an MCAP file, but not a bag of ROS 2.", where=str(self._path), todo=_WHAT
                ) from None
            raise self._damaged(reason_of(error)) from None

    def _damaged(self, reason: str) -> UsageError:
        repair = "rosbag reindex" if self._ros1 else "ros2 bag reindex"
        more = "" if self._path.suffix != ".mcap" else " `mcap recover` repairs a single .mcap file."
        return UsageError(
            f"The bag is damaged, or its recorder was killed: {reason}.",
            where=str(self._path),
            todo=f"Repair it with `{repair}`, and import it again.{more}",
        )
