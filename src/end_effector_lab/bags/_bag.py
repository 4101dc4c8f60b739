"""Open a bag of ROS 1 or ROS 2 with the library `rosbags`, and read its messages.

The messages are read by the definitions in the bag, since their version may differ.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from rosbags.interfaces import MessageDefinitionFormat
from rosbags.rosbag1 import Reader as Reader1
from rosbags.rosbag2 import Reader as Reader2
from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore

from end_effector_hal.errors import UsageError
from end_effector_hal.plugins import named

ROS1, MSG, IDL = "ros1msg", "ros2msg", "ros2idl"
"""The names of MCAP for the formats of message definitions."""
_IDL_BEGIN = "=" * 80 + "\n"


@dataclass(frozen=True, slots=True)
class BagMessage:
    """A message as it is stored in a bag.

    Attributes:
        topic: the topic on which it was published.
        type: such as ``std_msgs/msg/String``.
        log_us: the time of day at which it was recorded, µs.
        data: its bytes.
        definition: the definition of its fields; empty: the bag does not contain it.
        syntax: format of the definition.
    """

    topic: str
    type: str
    log_us: int
    data: bytes
    definition: str
    syntax: str

    @property
    def generation(self) -> int:
        """The generation of ROS that wrote the message, 1 or 2."""
        return 1 if self.syntax == ROS1 else 2

    def read(self) -> Any:
        """Return an object with the fields of the message; raises ValueError with a reason."""
        return _reader(self.type, self.definition, self.syntax)(self.data)


def plain_type(name: str) -> str:
    """Return ``package/Name``, the form in the table of the interface."""
    package, _, message = name.partition("/")
    return f"{package}/{message.removeprefix('msg/')}"


def reason_of(error: BaseException) -> str:
    """Return the message of a library's error for use within a sentence."""
    return named(error).rstrip(".")


@lru_cache(maxsize=64)
def _reader(kind: str, definition: str, syntax: str) -> Callable[[bytes], Any]:
    if not definition:
        reason = f"the bag does not define the fields of {plain_type(kind)}"
        return lambda _: _raise(reason)
    package, _, name = plain_type(kind).partition("/")
    kind = f"{package}/msg/{name}"
    try:
        store = get_typestore(Stores.EMPTY)
        if syntax in (ROS1, MSG):
            store.register(get_types_from_msg(definition, kind))
        else:
            for part in definition.split(_IDL_BEGIN):
                store.register(get_types_from_idl(part.partition("\n")[2] if part[:5] == "IDL: " else part))
    except Exception as error:  # noqa: BLE001 the library raises anything for what is no definition
        reason = f"its definition of {plain_type(kind)} cannot be read: {reason_of(error)}"
        return lambda _: _raise(reason)
    read = store.deserialize_ros1 if syntax == ROS1 else store.deserialize_cdr

    def checked(data: bytes) -> Any:
        try:
            return read(data, kind)
        except Exception as error:  # noqa: BLE001 and for bytes that are no message
            raise ValueError(f"its bytes are no {plain_type(kind)}: {reason_of(error)}") from None

    return checked


def _raise(reason: str) -> None:
    raise ValueError(reason)


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
