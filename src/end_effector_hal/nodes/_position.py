"""Node Position: the positions of the cylinders and of the tool changer, as their sensors show them."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import IntEnum
from functools import partial
from math import isnan, nan
from typing import Any

from end_effector_hal.control import Status
from end_effector_hal.description import ToolChanger
from end_effector_hal.sensing import JudgedReadings, ToolPlace, tool_place
from end_effector_hal.signals import Value
from end_effector_hal.vocabulary import Evidence
from end_effector_hal.wires import now_us

from .interface import (
    JOINT_STATES,
    POSITION,
    POSITION_TOOL_CHANGER,
    POSITION_TOOL_STAND,
    STATE_HZ,
    actuator_joints,
    grip_joint,
    grip_position,
    position_topics,
)
from .report import OK, WARN, Health, publish_health, silence
from .transport import (
    CylinderPositionMessage,
    JointStateMessage,
    MessageHeader,
    NodeTransport,
    PositionMessage,
)


class CylinderPlace(IntEnum):
    """The position of a cylinder (``CylinderPosition``)."""

    UNKNOWN = 0
    RETRACTED = 1
    BETWEEN = 2
    EXTENDED = 3


class ChangerPlace(IntEnum):
    """The position of the tool changer (``ToolChangerPosition``)."""

    UNKNOWN = 0
    LOCKED = 1
    UNLOCKED = 2
    BETWEEN = 3
    CONTRADICTORY = 4


CYLINDER = {
    Evidence.UNKNOWN: CylinderPlace.UNKNOWN,
    Evidence.GONE: CylinderPlace.RETRACTED,
    Evidence.PARTIAL: CylinderPlace.BETWEEN,
    Evidence.CONFIRMED: CylinderPlace.EXTENDED,
}
"""The position of a cylinder, by the evidence of its actuator."""
_CHANGER = {
    (True, False): ChangerPlace.LOCKED,
    (False, True): ChangerPlace.UNLOCKED,
    (False, False): ChangerPlace.BETWEEN,
    (True, True): ChangerPlace.CONTRADICTORY,
}


def changer_place(changer: ToolChanger, values: Mapping[str, Value]) -> ChangerPlace:
    """Return the position of the tool changer, by its two bits."""
    locked, unlocked = values.get(changer.locked_bit), values.get(changer.unlocked_bit)
    if locked is None or unlocked is None:
        return ChangerPlace.UNKNOWN
    return _CHANGER[bool(locked), bool(unlocked)]


_FRACTIONS: dict[IntEnum, float] = {CylinderPlace.RETRACTED: 0.0, CylinderPlace.EXTENDED: 1.0}
"""Fractions of the stroke at the positions that a switch proves."""


class PositionNode:
    """Publishes each position and the joints at every change and at 10 Hz; a stale position becomes UNKNOWN."""

    def __init__(self, node: NodeTransport) -> None:
        self._log, self._tool = node.log, node.tool()
        description = self._tool.description
        self._lock = threading.Lock()
        self._evidence, self._part = self._tool.status.evidence, self._tool.status.part
        self._values: Mapping[str, Value] = {}
        self._outputs: list[_Output] = []
        for name, topic in position_topics(description).items():
            read = partial(self._cylinder, description.sequence.index(name))
            self._outputs.append(_Output(name, node.publisher(topic), CylinderPlace, read, _cylinder_message))
        if changer := description.tool_changer:
            for name, topic, places, place in (
                ("tool_changer", POSITION_TOOL_CHANGER, ChangerPlace, changer_place),
                ("tool_stand", POSITION_TOOL_STAND, ToolPlace, tool_place),
            ):
                found = partial(self._of_changer, place, changer)
                self._outputs.append(_Output(name, node.publisher(topic), places, found, _message))
        self._publish_joints = node.publisher(JOINT_STATES)
        self._grip_joint, self._joints = grip_joint(description), actuator_joints(description)
        self._known_joints: dict[str, float] = {}
        self._known: dict[str, IntEnum] = {}
        self._tool.subscribe(self._on_status, name=POSITION)
        if changer:
            bits = changer.locked_bit, changer.unlocked_bit, changer.stand_bit, changer.present_bit
            self._tool.subscribe_readings(
                self._on_readings, name=POSITION, key=lambda now: [*map(now.values.get, bits)]
            )
        node.every(STATE_HZ, self._tick)
        publish_health(node, description.name, self._health)

    def _on_status(self, status: Status) -> None:
        with self._lock:
            self._evidence, self._part = status.evidence, status.part
            self._publish(status.at, every=False)

    def _on_readings(self, readings: JudgedReadings) -> None:
        with self._lock:
            self._values = readings.values
            self._publish(readings.at, every=False)

    def _tick(self) -> None:
        with self._lock:
            self._publish(now_us(), every=True)

    def _publish(self, at: int, *, every: bool) -> None:
        for output in self._outputs:
            position = output.read()
            before = self._known.get(output.name)
            if every or before != position:
                self._known[output.name] = position
                output.publish(output.message(position, at))
                old = before if before is not None else output.places(0)
                if old is not position:
                    self._log.info("%s: %s -> %s", output.name, old.name, position.name)

        joints = self._proven_joints()
        if joints and (every or joints != self._known_joints):
            message = JointStateMessage(list(joints), list(joints.values()), MessageHeader(at))
            self._publish_joints(message)
        self._known_joints = joints

    def _proven_joints(self) -> dict[str, float]:
        """Return the positions of the joints that are proven.

        Others are left out: NaN would break a transform, and an old value would be wrong.
        """
        found = {joint.name: joint.position(self._evidence) for joint in self._joints}
        found[self._grip_joint] = grip_position(self._evidence, self._tool.description.uses(self._part))
        return {name: position for name, position in found.items() if not isnan(position)}

    def _cylinder(self, index: int) -> CylinderPlace:
        return CYLINDER[self._evidence[index]]

    def _of_changer(
        self, place: Callable[[ToolChanger, Mapping[str, Value]], IntEnum], changer: ToolChanger
    ) -> IntEnum:
        return place(changer, self._values)

    def _health(self) -> Health:
        values = {
            output.name: self._known.get(output.name, output.places(0)).name for output in self._outputs
        }
        if silent := silence(self._tool):
            return Health(silent.level, silent.message, values)
        unknown = [name for name, position in values.items() if position == "UNKNOWN"]
        said = f"Not known: {', '.join(unknown)}." if unknown else ""
        return Health(WARN if said else OK, said or "All positions are known.", values)


@dataclass(frozen=True)
class _Output:
    """One position: its name, its publisher, its enumeration, and how it is read."""

    name: str
    publish: Callable[[Any], None]
    places: type[IntEnum]
    read: Callable[[], IntEnum]
    message: Callable[[IntEnum, int], PositionMessage | CylinderPositionMessage]


def _message(place: IntEnum, at_us: int) -> PositionMessage:
    return PositionMessage(place, place.name, MessageHeader(at_us))


def _cylinder_message(place: IntEnum, at_us: int) -> CylinderPositionMessage:
    return CylinderPositionMessage(place, place.name, _FRACTIONS.get(place, nan), MessageHeader(at_us))
