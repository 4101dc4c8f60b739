"""Node Position: where the cylinders and the tool changer stand, by their sensors."""

from __future__ import annotations

import threading
from collections.abc import Sequence
from typing import Any

from end_effector_msgs.msg import CylinderPosition, ToolChangerPosition

from end_effector_hal.control import Evidence, Senses
from end_effector_hal.description import Description, ToolChanger
from end_effector_hal.wires import get_codec, now_us

from ._diagnostics import OK, WARN, Health, diagnose
from ._frames import frame_from_message
from ._node import Node, stamp
from ._table import POSITION, POSITION_TOOL_CHANGER, SENSOR_FRAME, STATE_HZ, position_topics

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
        self._kinds = codec.channels
        self._senses = Senses(description, codec)
        self._changer = description.tool_changer
        self._lock = threading.Lock()
        self._outputs: list[tuple[str, Any, Any]] = [
            (name, node.publisher(topic), CylinderPosition)
            for name, topic in position_topics(description).items()
        ]
        self._order = {name: index for index, name in enumerate(description.sequence)}
        if self._changer is not None:
            self._outputs.append(("", node.publisher(POSITION_TOOL_CHANGER), ToolChangerPosition))
        self._known: dict[str, int] = {}
        node.subscribe(SENSOR_FRAME, self._on_frame)
        node.every(STATE_HZ, self._tick)
        diagnose(node, description.name, self._health)

    def _on_frame(self, message: Any) -> None:
        with self._lock:
            self._senses.frame(frame_from_message(message, self._kinds))
            self._publish(message.at_us, every=False)

    def _tick(self) -> None:
        with self._lock:
            at = now_us()
            self._senses.advance(at)
            self._publish(at, every=True)

    def _publish(self, at: int, *, every: bool) -> None:
        for name, publish, kind in self._outputs:
            position = self._cylinder(name) if name else self._tool_changer(at)
            if every or self._known.get(name) != position:
                self._known[name] = position
                message = kind(position=position)
                message.header.stamp = stamp(at)
                publish(message)

    def _cylinder(self, name: str) -> int:
        position: int = _CYLINDER[self._senses.evidence[self._order[name]]]
        return position

    def _tool_changer(self, at: int) -> int:
        changer: ToolChanger | None = self._changer
        locked = self._senses.readings.get(changer.locked_bit if changer else None, at)
        unlocked = self._senses.readings.get(changer.unlocked_bit if changer else None, at)
        if locked is None or unlocked is None:
            return int(ToolChangerPosition.UNKNOWN)
        position: int = _CHANGER[bool(locked), bool(unlocked)]
        return position

    def _health(self) -> Health:
        unknown = [name or "tool_changer" for name, position in self._known.items() if position == 0]
        if not unknown:
            return Health(OK, "All positions are known.")
        return Health(WARN, f"Not known: {', '.join(unknown)}.")


def main(argv: Sequence[str]) -> int:
    """Run the node."""
    node = Node(POSITION, argv)
    PositionNode(node, node.description())
    return node.spin()
