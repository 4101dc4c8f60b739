"""Bags as the tests want them: written with the library's writers, from the text of our message definitions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from math import nan
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy
from rosbags.interfaces import Nodetype
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

MESSAGES = Path(__file__).parents[2] / "ros/end_effector_msgs/msg"
STATE, COMMAND = (f"end_effector_msgs/msg/{name}" for name in ("EndEffectorState", "SupervisorCommand"))
PRESSURE = "sensor_msgs/msg/FluidPressure"
TOPICS = {
    "bottom": "/PressureVacuumBottom",
    "cylinder": "/PressureCylinder",
    "top": "/PressureVacuumTop",
    "supply": "/PressureSupply",
}
NAMES = ["bottom_vacuum", "cylinder", "top_vacuum"]
STARTED_US = 1_790_000_000_000_000
"""When the bags begin, time of day."""

Message = tuple[str, str, int, Mapping[str, Any]]
"""Topic, type, when it was written down (µs since the bag began), its fields."""


def state(
    at_us: int, log_us: int, state: int = 0, *, topic: str = "/EndEffectorState", **fields: Any
) -> Message:
    """A state of the paper's tool."""
    given = {
        "at_us": at_us, "since_us": 1, "tool": "verdin_gripper", "state": state, "command": -1,
        "actuator_names": NAMES, "actuator_kinds": ["vacuum", "cylinder", "vacuum"], "actuators": [0, 0, 0],
    }  # fmt: skip
    return topic, STATE, log_us, {**given, **fields}


def frame(log_us: int, **channels: int | None) -> list[Message]:
    """The pressures of a frame, gauge; None: carried, but not valid."""
    absolute = {channel: nan if value is None else 101_325.0 + value for channel, value in channels.items()}
    return [
        (TOPICS[channel], PRESSURE, log_us, {"fluid_pressure": value}) for channel, value in absolute.items()
    ]


def definitions(change: Callable[[str, str], str] = lambda name, text: text) -> dict[str, Any]:
    """The types of ``end_effector_msgs``; ``change`` makes another text of one."""
    found: dict[str, Any] = {}
    for path in sorted(MESSAGES.glob("*.msg")):
        text = change(path.stem, path.read_text())
        found.update(get_types_from_msg(text, f"end_effector_msgs/msg/{path.stem}"))
    return found


def write_ros1(
    path: Path,
    messages: Iterable[Message],
    types: Mapping[str, Any] | None = None,
    *,
    compression: str = "none",
) -> Path:
    """A ``.bag`` of ROS 1."""
    store = _store(Stores.ROS1_NOETIC, types)
    opened = Writer1(path)
    if compression != "none":
        opened.set_compression(Writer1.CompressionFormat[compression.upper()])
    with opened as writer:
        connections: dict[str, Any] = {}
        for topic, kind, log_us, fields in messages:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store)
            data = store.serialize_ros1(_filled(store, kind, fields), kind)
            writer.write(connections[topic], (STARTED_US + log_us) * 1000, data)
    return path


def write_ros2(
    path: Path,
    messages: Iterable[Message],
    types: Mapping[str, Any] | None = None,
    *,
    mcap: bool = True,
    compression: CompressionMode = CompressionMode.NONE,
) -> Path:
    """A folder of rosbag2."""
    store = _store(Stores.ROS2_JAZZY, types)
    writer = Writer2(path, version=9, storage_plugin=StoragePlugin.MCAP if mcap else StoragePlugin.SQLITE3)
    writer.set_compression(compression, CompressionFormat.ZSTD)
    with writer:
        connections: dict[str, Any] = {}
        for topic, kind, log_us, fields in messages:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store)
            data = store.serialize_cdr(_filled(store, kind, fields), kind)
            writer.write(connections[topic], (STARTED_US + log_us) * 1000, data)
    return path


def _store(standard: Any, types: Mapping[str, Any] | None) -> Any:
    store = get_typestore(standard)
    store.register(dict(types) if types is not None else definitions())
    return store


ZERO: dict[str, Any] = {"string": "", "bool": False, "float32": 0.0, "float64": 0.0}


def _filled(store: Any, kind: str, fields: Mapping[str, Any]) -> Any:
    """A message with all fields of its type; those that are not given are zero or empty."""
    message = SimpleNamespace()
    for name, (node, what) in store.fielddefs[kind][1]:
        if name in fields:
            value = fields[name]
        elif node == Nodetype.BASE:
            value = ZERO.get(what[0], 0)
        elif node == Nodetype.NAME:
            value = _filled(store, what, {})
        else:
            value = []
        if name in fields and node == Nodetype.SEQUENCE and what[0][0] == Nodetype.NAME:
            value = [_filled(store, what[0][1], each) for each in value]
        if node in (Nodetype.ARRAY, Nodetype.SEQUENCE) and what[0][0] == Nodetype.BASE:
            element = what[0][1][0]
            if element != "string":
                value = numpy.array(value, dtype=element)
        setattr(message, name, value)
    return message
