"""Node Position: the positions of the cylinders and of the tool changer, as their sensors show them."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from math import isnan, nan
from typing import Any

from end_effector_hal.codecs import carrier_of
from end_effector_hal.description import ToolChanger
from end_effector_hal.sensing import SensorSet, ToolPlace, tool_place
from end_effector_hal.vocabulary import Evidence
from end_effector_hal.wires import now_us

from .interface import (
    JOINT_STATES,
    POSITION_TOOL_CHANGER,
    POSITION_TOOL_STAND,
    SENSOR_FRAME,
    STATE_HZ,
    actuator_joints,
    grip_joint,
    grip_position,
    position_topics,
)
from .report import OK, WARN, Health, publish_health
from .transport import (
    ChangerPlace,
    CylinderPlace,
    CylinderPositionMessage,
    FrameMessage,
    JointStateMessage,
    MessageHeader,
    NodeTransport,
    PositionMessage,
)

_CYLINDER = {
    Evidence.UNKNOWN: CylinderPlace.UNKNOWN,
    Evidence.GONE: CylinderPlace.RETRACTED,
    Evidence.PARTIAL: CylinderPlace.BETWEEN,
    Evidence.CONFIRMED: CylinderPlace.EXTENDED,
}
_FRACTIONS: dict[IntEnum, float] = {CylinderPlace.RETRACTED: 0.0, CylinderPlace.EXTENDED: 1.0}
"""Fractions of the stroke at the positions that a switch proves."""
_CHANGER = {
    (True, False): ChangerPlace.LOCKED,
    (False, True): ChangerPlace.UNLOCKED,
    (False, False): ChangerPlace.BETWEEN,
    (True, True): ChangerPlace.CONTRADICTORY,
}


class PositionNode:
    """Publishes each position and the joints at every change and at 10 Hz; a stale position becomes UNKNOWN."""

    def __init__(self, node: NodeTransport) -> None:
        description = node.description()
        self._log, self._frames = node.log, node.frames(description)
        self._senses = SensorSet(description, carrier_of(description))
        self._looked_us = 0
        self._lock = threading.Lock()
        order = {name: index for index, name in enumerate(description.sequence)}
        self._outputs = [
            _Output(
                name, node.publisher(topic), CylinderPlace, self._cylinder(order[name]), _cylinder_message
            )
            for name, topic in position_topics(description).items()
        ]
        if changer := description.tool_changer:
            publish = node.publisher(POSITION_TOOL_CHANGER)
            self._outputs += [
                _Output("tool_changer", publish, ChangerPlace, self._tool_changer(changer), _message),
                _Output(
                    "tool_stand",
                    node.publisher(POSITION_TOOL_STAND),
                    ToolPlace,
                    self._stand(changer),
                    _message,
                ),
            ]
        self._publish_joints = node.publisher(JOINT_STATES)
        self._grip_joint, self._joints = grip_joint(description), actuator_joints(description)
        self._known_joints: dict[str, float] = {}
        self._known: dict[str, IntEnum] = {}
        node.on_start(lambda: node.subscribe(SENSOR_FRAME, self._on_frame))
        node.every(STATE_HZ, self._tick)
        publish_health(node, description.name, self._health)

    def _on_frame(self, message: FrameMessage) -> None:
        frame = self._frames.frame_of(message)
        with self._lock:
            if self._senses.accepts(frame, now_us()):
                self._senses.frame(frame)
                self._looked_us = self._senses.at
                self._publish(self._looked_us, every=False)

    def _tick(self) -> None:
        with self._lock:
            at = now_us()
            due = self._senses.deadline(self._looked_us)
            if due is not None and due <= at:
                self._senses.advance(at)
            self._looked_us = at
            self._publish(at, every=True)

    def _publish(self, at: int, *, every: bool) -> None:
        for output in self._outputs:
            position = output.places(output.read(at))
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
        evidence = self._senses.now.evidence
        found = {joint.name: joint.position(evidence) for joint in self._joints}
        found[self._grip_joint] = grip_position(evidence)
        return {name: position for name, position in found.items() if not isnan(position)}

    def _cylinder(self, index: int) -> Callable[[int], int]:
        return lambda _at: _CYLINDER[self._senses.now.evidence[index]]

    def _tool_changer(self, changer: ToolChanger) -> Callable[[int], int]:
        def read(at: int) -> int:
            locked = self._senses.now.readings.get(changer.locked_bit, at)
            unlocked = self._senses.now.readings.get(changer.unlocked_bit, at)
            if locked is None or unlocked is None:
                return ChangerPlace.UNKNOWN
            return _CHANGER[bool(locked), bool(unlocked)]

        return read

    def _stand(self, changer: ToolChanger) -> Callable[[int], int]:
        return lambda at: tool_place(changer, self._senses.now.readings.judged(at).values)

    def _health(self) -> Health:
        values = {
            output.name: self._known.get(output.name, output.places(0)).name for output in self._outputs
        }
        unknown = [name for name, position in values.items() if position == "UNKNOWN"]
        with self._lock:
            refused = self._senses.refusals(now_us())
            values["sensor frames refused"] = str(self._senses.refused)
        said = " ".join(([f"Not known: {', '.join(unknown)}."] if unknown else []) + [*map(str, refused)])
        return Health(WARN if said else OK, said or "All positions are known.", values)


@dataclass(frozen=True)
class _Output:
    """One position: its name, its publisher, its enumeration, and how it is read at a time in µs."""

    name: str
    publish: Callable[[Any], None]
    places: type[IntEnum]
    read: Callable[[int], int]
    message: Callable[[IntEnum, int], PositionMessage | CylinderPositionMessage]


def _message(place: IntEnum, at_us: int) -> PositionMessage:
    return PositionMessage(place, place.name, MessageHeader(at_us))


def _cylinder_message(place: IntEnum, at_us: int) -> CylinderPositionMessage:
    return CylinderPositionMessage(place, place.name, _FRACTIONS.get(place, nan), MessageHeader(at_us))
