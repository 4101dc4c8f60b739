"""Node Position: where the cylinders and the tool changer stand, by their sensors."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from end_effector_msgs.msg import CylinderPosition, ToolChangerPosition, ToolStandPosition

from end_effector_hal.codecs import get_codec
from end_effector_hal.description import Description, ToolChanger
from end_effector_hal.sensing import Senses, tool_place
from end_effector_hal.vocabulary import Evidence
from end_effector_hal.wires import now_us

from ._diagnostics import OK, WARN, Health, diagnose
from ._frames import frame_from_message
from ._node import Node, constant_name, stamp
from ._table import (
    POSITION,
    POSITION_TOOL_CHANGER,
    POSITION_TOOL_STAND,
    SENSOR_FRAME,
    STATE_HZ,
    position_topics,
)

_CYLINDER = {
    Evidence.UNKNOWN: CylinderPosition.UNKNOWN,
    Evidence.GONE: CylinderPosition.RETRACTED,
    Evidence.PARTIAL: CylinderPosition.BETWEEN,
    Evidence.CONFIRMED: CylinderPosition.EXTENDED,
}
_CHANGER = {
    (True, False): ToolChangerPosition.LOCKED,
    (False, True): ToolChangerPosition.UNLOCKED,
    (False, False): ToolChangerPosition.BETWEEN,
    (True, True): ToolChangerPosition.CONTRADICTORY,
}


class PositionNode:
    """Published at every change, and at 10 Hz; what is stale turns UNKNOWN by itself."""

    def __init__(self, node: Node, description: Description) -> None:
        codec = get_codec(description.link.codec)
        self._log, self._kinds = node.log, codec.channels
        self._senses = Senses(description, codec)
        self._lock = threading.Lock()
        order = {name: index for index, name in enumerate(description.sequence)}
        self._outputs = [
            _Output(name, node.publisher(topic), CylinderPosition, self._cylinder(order[name]))
            for name, topic in position_topics(description).items()
        ]
        if changer := description.tool_changer:
            publish = node.publisher(POSITION_TOOL_CHANGER)
            self._outputs += [
                _Output("tool_changer", publish, ToolChangerPosition, self._tool_changer(changer)),
                _Output(
                    "tool_stand", node.publisher(POSITION_TOOL_STAND), ToolStandPosition, self._stand(changer)
                ),
            ]
        self._known: dict[str, int] = {}
        node.subscribe(SENSOR_FRAME, self._on_frame)
        node.every(STATE_HZ, self._tick)
        diagnose(node, description.name, self._health)

    def _on_frame(self, message: Any) -> None:
        frame = frame_from_message(message, self._kinds)
        with self._lock:
            if self._senses.accepts(frame, now_us()):
                self._senses.frame(frame)
                self._publish(frame.at, every=False)

    def _tick(self) -> None:
        with self._lock:
            at = now_us()
            self._senses.advance(at)
            self._publish(at, every=True)

    def _publish(self, at: int, *, every: bool) -> None:
        when = stamp(at)
        for output in self._outputs:
            position = output.read(at)
            before = self._known.get(output.name)
            if every or before != position:
                self._known[output.name] = position
                message = output.kind(position=position)
                if (before or 0) != position:
                    old, new = (constant_name(message, each) for each in (before or 0, position))
                    self._log.info("%s: %s -> %s", output.name, old, new)
                message.header.stamp = when
                output.publish(message)

    def _cylinder(self, index: int) -> Callable[[int], int]:
        return lambda _at: int(_CYLINDER[self._senses.evidence[index]])

    def _tool_changer(self, changer: ToolChanger) -> Callable[[int], int]:
        def read(at: int) -> int:
            locked = self._senses.readings.get(changer.locked_bit, at)
            unlocked = self._senses.readings.get(changer.unlocked_bit, at)
            if locked is None or unlocked is None:
                return int(ToolChangerPosition.UNKNOWN)
            return int(_CHANGER[bool(locked), bool(unlocked)])

        return read

    def _stand(self, changer: ToolChanger) -> Callable[[int], int]:
        return lambda at: int(tool_place(changer, self._senses.readings, at))

    def _health(self) -> Health:
        values = {
            output.name: constant_name(output.kind(), self._known.get(output.name, 0))
            for output in self._outputs
        }
        unknown = [name for name, position in values.items() if position == "UNKNOWN"]
        with self._lock:
            refused = self._senses.refusals(now_us())
            values["sensor frames refused"] = str(self._senses.refused)
        said = " ".join(([f"Not known: {', '.join(unknown)}."] if unknown else []) + [*refused])
        return Health(WARN if said else OK, said or "All positions are known.", values)


@dataclass(frozen=True)
class _Output:
    """One position: its name, where it goes, and how it is read at a time in µs."""

    name: str
    publish: Callable[[Any], None]
    kind: Any
    read: Callable[[int], int]


def main(argv: Sequence[str]) -> int:
    """Run the node."""
    node = Node(POSITION, argv)
    PositionNode(node, node.description())
    return node.spin()
