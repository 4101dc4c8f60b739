"""Node Pressure: owns the sensor link; publishes every frame, and its pressures in ROS's units."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import Any

from sensor_msgs.msg import FluidPressure

from end_effector_hal.codecs import get_codec
from end_effector_hal.description import Description
from end_effector_hal.runtime import Witness
from end_effector_hal.sensing import Senses
from end_effector_hal.signals import Frame, Value
from end_effector_hal.wires import now_us
from end_effector_hal.wires.link import LinkHealth, LinkReader, LinkState

from ._diagnostics import ERROR, OK, WARN, Health, diagnose
from ._frames import absolute_pa, frame_to_message
from ._node import Node, stamp
from ._table import PRESSURE, SENSOR_FRAME, STATE_HZ, pressure_topics


class PressureNode:
    """Frames in, messages out, in the thread of the link: the frame first, for the reaction depends on it.

    Before it, and only when it proves something else than before, the line owner is told: this node reads the
    sensors, so the interlocks that need one (IL-01, IL-02, IL-05, IL-13) rest on what it says.

    A pressure that is invalid, doubted or stale is NaN, never the last value; what is stale is told so once.
    """

    def __init__(self, node: Node, description: Description) -> None:
        self._log = node.log
        self._frame = node.publisher(SENSOR_FRAME)
        self._pressures: list[tuple[str, Callable[[Any], None]]] = [
            (channel, node.publisher(topic)) for channel, topic in pressure_topics(description)
        ]
        link = description.link
        self._senses = Senses(description, get_codec(link.codec))
        self._lock = threading.Lock()
        self._silent = False
        self._witness = Witness(description)
        node.on_close(self._witness.close)
        self._witness.start()
        self._reader = LinkReader(
            link.port, link.codec, link.baudrate, on_frame=self._on_frame, on_change=self._on_change
        )
        diagnose(node, link.port, self._health)
        node.on_close(self._reader.close)
        self._reader.start()
        node.every(STATE_HZ, self._tick)

    def _on_frame(self, frame: Frame) -> None:
        self._witness.frame(frame)
        self._frame(frame_to_message(frame))
        with self._lock:
            if not self._senses.accepts(frame, now_us()):
                return
            self._silent = False
            self._senses.frame(frame)
            readings = self._senses.readings
            self._tell(
                stamp(frame.at),
                lambda channel: readings.get(channel, frame.at) if readings.arrived(channel) else None,
            )

    def _tick(self) -> None:
        with self._lock:
            at = now_us()
            self._senses.advance(at)
            if self._silent or self._senses.readings.fresh(at):
                return
            self._silent = True
            self._tell(stamp(at), lambda _: None)

    def _tell(self, when: Any, value: Callable[[str], Value]) -> None:
        """All pressures; one stamp for what one frame brought, so that they can be put together again."""
        for channel, publish in self._pressures:
            message = FluidPressure(fluid_pressure=absolute_pa(value(channel)))
            message.header.stamp, message.header.frame_id = when, channel
            publish(message)

    def _on_change(self, health: LinkHealth) -> None:
        if health.state is LinkState.DOWN:
            self._log.error("%s", health.error)
        else:
            self._log.info("the sensor link is %s", health.state.value)

    def _health(self) -> Health:
        health, at = self._reader.health, now_us()
        with self._lock:
            up, notices = self._senses.readings.link_up(at), self._senses.notices(at, held=False)
        counters = {name: getattr(health, name) for name in ("opened", "bytes", "frames", "lost", "reboots")}
        errors = {f"errors, {kind}": count for kind, count in health.errors.items()}
        values = counters | errors
        if health.state is not LinkState.UP:
            level = ERROR if health.state is LinkState.DOWN else WARN
            return Health(level, health.error or f"The link is {health.state.value}.", values)
        if not up:
            return Health(ERROR, f"The port is open, but no frame comes ({_since(health, at)}).", values)
        return Health(WARN if notices else OK, " ".join(notices) or "The link is up.", values)


def _since(health: LinkHealth, at: int) -> str:
    return f"for {(at - (health.last_frame or health.since)) / 1e6:.1f} s"


def main(argv: Sequence[str]) -> int:
    """Run the node."""
    node = Node(PRESSURE, argv)
    PressureNode(node, node.description())
    return node.spin()
