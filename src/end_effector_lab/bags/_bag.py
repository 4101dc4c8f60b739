"""Open a bag of ROS 1 or ROS 2 with the library `rosbags`, and read its messages.

The messages are read by the definitions in the bag, since their version may differ: every field is checked. Their
stamps are placed on one time axis, as a machine may have been restarted in the middle of a bag.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields
from functools import lru_cache
from math import isfinite
from pathlib import Path
from typing import Any, TypeVar

from rosbags.interfaces import MessageDefinitionFormat
from rosbags.rosbag1 import Reader as Reader1
from rosbags.rosbag2 import Reader as Reader2
from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore

from end_effector_hal.errors import UsageError
from end_effector_hal.nodes.data_logger import events_of
from end_effector_hal.nodes.transport import AMBIENT_PA, EventMessage, StateMessage
from end_effector_hal.plugins import named
from end_effector_hal.recording import is_part_name
from end_effector_hal.vocabulary import ActuatorState, Command, EndEffectorState

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


Value = TypeVar("Value")
OPTIONAL = ("since_us", "count", "tool", "tool_changer", "alarms", "alarm_ids", "events")
"""Fields of a state that are used, but that an older version may lack."""
_KINDS: dict[Any, type] = {"int": int, "str": str}


def state_of(content: Any) -> StateMessage:
    """Return the state; fields that the bag lacks are empty. Raises ValueError if it is not a state."""
    used: dict[str, Any] = {
        "at_us": _one(content, "at_us", int),
        "state": EndEffectorState(_one(content, "state", int)),
        "command": Command(_one(content, "command", int)),
        "actuator_names": _list(content, "actuator_names", str),
        "actuator_kinds": _list(content, "actuator_kinds", str),
        "actuators": [ActuatorState(each) for each in _list(content, "actuators", int)],
        "since_us": _one(content, "since_us", int, 0),
        "count": _one(content, "count", int, 0),
        "tool": _one(content, "tool", str, ""),
        "tool_changer": _one(content, "tool_changer", int, 0),
        "part": _one(content, "part", str),
        "alarms": _list(content, "alarms", str, []),
        "alarm_ids": _list(content, "alarm_ids", str, []),
        "events": [_event(each) for each in getattr(content, "events", ())],
    }
    if len(used["actuator_names"]) != len(used["actuators"]):
        raise ValueError("its lists are not of the same length")
    if not is_part_name(used["part"]):
        raise ValueError("its part is not a name")
    unused: dict[str, Any] = {each.name: None for each in fields(StateMessage) if each.name not in used}
    message = StateMessage(**used, **unused)
    events_of(message)
    return message


def _event(content: Any) -> EventMessage:
    return EventMessage(
        **{each.name: _one(content, each.name, _KINDS[each.type]) for each in fields(EventMessage)}
    )


def pressure_of(content: Any) -> int | None:
    """Return the gauge pressure, Pa; None: not known. Raises ValueError if it is not a pressure."""
    absolute = _one(content, "fluid_pressure", float)
    return round(absolute) - AMBIENT_PA if isfinite(absolute) else None


def command_of(content: Any) -> tuple[Command, str]:
    """Return the command, and the part that a grip is for; raises ValueError if it is not a command."""
    return Command(_one(content, "command", int)), _one(content, "part", str)


def lacking(content: Any) -> tuple[str, ...]:
    """Return the fields that this version uses and that the state lacks."""
    return tuple(each for each in OPTIONAL if not hasattr(content, each))


def _one(content: Any, name: str, kind: Callable[..., Value], default: Value | None = None) -> Value:
    value: Value | None = getattr(content, name, default)
    if value is None:
        raise ValueError(f"it has no field {name}")
    if type(value) is not kind:
        raise ValueError(f"its field {name} is of another type")
    return value


def _list(content: Any, name: str, kind: type[Value], default: list[Value] | None = None) -> list[Value]:
    values = getattr(content, name, default)
    if values is None:
        raise ValueError(f"it has no field {name}")
    found = values.tolist() if hasattr(values, "tolist") else values  # an array of numpy
    if not isinstance(found, list) or not all(type(each) is kind for each in found):
        raise ValueError(f"its field {name} is of another type")
    return found


BACK_US = 2_000_000
"""A stamp that is further back than this belongs to a restarted clock, µs."""
AHEAD_US = 3_600_000_000
"""A stamp that is further ahead of the bag's own time than this is of another clock, or invalid, µs."""


class LineOfTime:
    """Places stamps on one time axis. When the clock jumps, the recording times of the messages give the elapsed time.

    Attributes:
        jumps: number of jumps of the clock.
    """

    def __init__(self) -> None:
        self.jumps = 0
        self._shift = 0
        self._last: dict[str, tuple[int, int | None]] = {}

    def place(self, stream: str, at: int, log_us: int, *, fresh: bool) -> int:
        """Return the place of a stamp, µs.

        Args:
            stream: name of the stream; the stamps of one stream are in order.
            at: time on the monotonic clock of the machine that made the stamp, µs.
            log_us: time at which the message was recorded, µs.
            fresh: whether the first stamp of the stream was made when its message was published.
        """
        placed = at + self._shift
        if stream not in self._last:
            self._last[stream] = (placed, log_us if fresh else None)
            return placed
        before, since = self._last[stream]
        if placed == before:
            return placed  # a state that is repeated: it was made at the first of them
        passed = 0 if since is None else max(0, log_us - since)
        behind = placed < before - BACK_US
        if behind or (since is not None and placed > before + passed + AHEAD_US):
            self._shift += before + passed - placed
            self.jumps += 1
            placed = before + passed
        self._last[stream] = (placed, log_us)
        return placed
