"""Node Pressure: owns the sensor link; publishes every frame, and its pressures in ROS's units."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from sensor_msgs.msg import FluidPressure

from end_effector_hal.description import Description
from end_effector_hal.tool import Witness
from end_effector_hal.wires import Frame, LinkHealth, LinkReader, LinkState

from ._diagnostics import ERROR, OK, WARN, Health, diagnose
from ._frames import absolute_pa, frame_to_message
from ._node import Node, stamp
from ._table import PRESSURE, SENSOR_FRAME, pressure_topics


class PressureNode:
    """Frames in, messages out, in the thread of the link: the frame first, for the reaction depends on it.

    Before it, and only when it proves something else than before, the line owner is told: this node reads the
    sensors, so the interlocks that need one (IL-01, IL-05, IL-13) rest on what it says.
    """

    def __init__(self, node: Node, description: Description) -> None:
        self._log = node.log
        self._frame = node.publisher(SENSOR_FRAME)
        self._pressures: list[tuple[str, Callable[[Any], None]]] = [
            (channel, node.publisher(topic)) for channel, topic in pressure_topics(description)
        ]
        link = description.link
        self._witness = Witness(description)
        node.on_close(self._witness.close)
        self._witness.start()
        self._reader = LinkReader(
            link.port, link.codec, link.baudrate, on_frame=self._on_frame, on_change=self._on_change
        )
        diagnose(node, link.port, self._health)
        node.on_close(self._reader.close)
        self._reader.start()

    def _on_frame(self, frame: Frame) -> None:
        self._witness.frame(frame)
        self._frame(frame_to_message(frame))
        now = stamp(frame.at)
        for channel, publish in self._pressures:
            message = FluidPressure(fluid_pressure=absolute_pa(frame.values.get(channel)))
            message.header.stamp, message.header.frame_id = now, channel
            publish(message)

    def _on_change(self, health: LinkHealth) -> None:
        if health.state is LinkState.DOWN:
            self._log.error("%s", health.error)
        else:
            self._log.info("the sensor link is %s", health.state.value)

    def _health(self) -> Health:
        health = self._reader.health
        level = {LinkState.UP: OK, LinkState.DOWN: ERROR}.get(health.state, WARN)
        counters = {name: getattr(health, name) for name in ("opened", "bytes", "frames", "lost", "reboots")}
        errors = {f"errors, {kind}": count for kind, count in health.errors.items()}
        return Health(level, health.error or f"The link is {health.state.value}.", counters | errors)


def main(argv: Sequence[str]) -> int:
    """Run the node."""
    node = Node(PRESSURE, argv)
    PressureNode(node, node.description())
    return node.spin()
