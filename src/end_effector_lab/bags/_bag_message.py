"""Reads the messages of a bag by the definitions in the bag, since their version may differ."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore

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
