"""Node Pressure: reads the sensor link and the inputs of the board; publishes every frame, and its pressures in Pa."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from end_effector_hal.arbiter import REPEAT_US, PredicatePublisher
from end_effector_hal.codecs import carrier_of
from end_effector_hal.sensing import SensorSet
from end_effector_hal.signals import Frame, Value
from end_effector_hal.wires import now_us
from end_effector_hal.wires.inputs import InputsHealth
from end_effector_hal.wires.link import LinkHealth, LinkState
from end_effector_hal.wires.sensors import SensorReader

from .interface import FRAME_ID, SENSOR_FRAME, STATE_HZ, pressure_topics
from .report import ERROR, OK, WARN, Health, publish_health
from .transport import (
    AMBIENT_PA,
    MessageHeader,
    NodeTransport,
    PressureMessage,
    absolute_pa,
)


class PressureNode:
    """Publishes the frames of the link in the thread of the link: the frame first, because the reaction depends on it.

    If a frame changes a predicate, the line arbiter gets the predicates before the frame is published: this node reads
    the sensors on which the interlocks IL-01, IL-02, IL-05, IL-07 and IL-13 depend, except the input lines that the
    arbiter reads itself.

    A pressure that is invalid, doubted or stale is NaN, never the last value; NaN is published once.
    """

    def __init__(self, node: NodeTransport) -> None:
        description, self._log = node.description(), node.log
        self._frame = node.publisher(SENSOR_FRAME)
        self._frame_id = node.parameter(FRAME_ID) or f"{description.name}_link"
        self._pressures: dict[str, Callable[[Any], None]] = {
            channel: node.publisher(topic) for channel, topic in pressure_topics(description)
        }
        self._frames = node.frames(description)
        self._senses = SensorSet(description, carrier_of(description))
        self._looked_us = 0
        self._lock = threading.Lock()
        self._unknown: set[str] = set()
        """Pressures whose last published value is NaN."""
        self._predicates = PredicatePublisher(description)
        node.on_close(self._predicates.close)
        self._predicates.use(self._senses)
        self._reader = SensorReader(description, on_frame=self._on_frame, on_change=self._on_change)
        publish_health(node, description.name, self._health, hardware=self._reader.where)
        node.on_close(self._reader.close)
        node.every(STATE_HZ, self._tick)
        if self._predicates.repeats:
            node.every(1e6 / REPEAT_US, self._repeat)
        node.on_start(self._reader.start, last=True)

    def _on_frame(self, frame: Frame) -> None:
        with self._lock:
            accepted = self._senses.accepts(frame, now_us())
            if accepted:
                self._look(frame.at - 1)
                self._senses.frame(frame)
                self._looked_us = self._senses.at
            self._predicates.publish(None if accepted else frame)
        self._frame(self._frames.message_of(frame))
        with self._lock:
            self._predicates.repeat()
            if not accepted:
                return
            readings = self._senses.now.readings
            for channel in self._pressures:
                if channel in frame.values or channel not in readings.carried:
                    value = readings.get(channel, frame.at) if readings.arrived(channel) else None
                    self._publish_pressure(channel, value, frame.at)

    def _tick(self) -> None:
        with self._lock:
            at = now_us()
            self._look(at)
            readings = self._senses.now.readings
            stale = readings.stale(at)
            for channel in self._pressures.keys() - self._unknown:
                if channel in stale or channel not in readings.carried:
                    self._publish_pressure(channel, None, at)

    def _repeat(self) -> None:
        """Repeat the predicates of a slow link while its readings are fresh."""
        with self._lock:
            at = now_us()
            self._look(at)
            self._predicates.repeat(at)

    def _look(self, at: int) -> None:
        """Let readings turn stale that do so until ``at`` µs."""
        due = self._senses.deadline(self._looked_us)
        if due is not None and due <= at:
            self._senses.advance(at)
        self._looked_us = max(self._looked_us, at)

    def _publish_pressure(self, channel: str, value: Value, at_us: int) -> None:
        (self._unknown.add if value is None else self._unknown.discard)(channel)
        self._pressures[channel](PressureMessage(absolute_pa(value), MessageHeader(at_us, self._frame_id)))

    def _on_change(self, source: str, health: LinkHealth | InputsHealth) -> None:
        if health.error:
            self._log.error("%s", health.error)
        elif isinstance(health, InputsHealth):
            self._log.info("the %s are read", source)
        else:
            self._log.info("%s", " ".join((f"the {source} is {health.state.value}", *health.faults)))

    def _health(self) -> Health:
        health, at = self._reader.health, now_us()
        with self._lock:
            readings = self._senses.now.readings
            notices = tuple(map(str, self._senses.notices(at, held=False)))
            up = readings.link_up(at)
        links, inputs = health.links, health.inputs
        told: list[Health] = []
        for name, link in links.items():
            if inputs or name:  # which of them is silent
                up = at - (link.last_frame or 0) < readings.down_us
            notes = (*(() if told else notices), *link.faults)
            told.append(_of_link(link, at, notes, up=up, name=name))
        if inputs:
            told.append(_of_inputs(inputs, () if links else notices, up=up or bool(links)))
        found = told[0] if len(told) == 1 else _together(told)
        return replace(found, values={**found.values, "ambient added (Pa)": AMBIENT_PA})


def _of_link(health: LinkHealth, at: int, notices: Sequence[str], *, up: bool, name: str) -> Health:
    counters = {each: getattr(health, each) for each in ("opened", "bytes", "frames", "lost", "reboots")}
    errors = {f"errors, {kind}": count for kind, count in health.errors.items()}
    values = {f"{name}, {key}" if name else key: value for key, value in (counters | errors).items()}
    link = f"link {name}" if name else "link"
    if health.state is not LinkState.UP:
        level = ERROR if health.state is LinkState.DOWN else WARN
        return Health(level, health.error or f"The {link} is {health.state.value}.", values)
    if not up:
        port = f"The port of {link}" if name else "The port"
        faults = " ".join(("", *health.faults))
        return Health(ERROR, f"{port} is open, but no frame comes ({_since(health, at)}).{faults}", values)
    return Health(WARN if notices else OK, " ".join(notices) or f"The {link} is up.", values)


def _of_inputs(health: InputsHealth, notices: Sequence[str], *, up: bool) -> Health:
    values = {f"inputs, {name}": getattr(health, name) for name in ("opened", "frames", "edges", "lost")}
    if health.error:
        return Health(ERROR, health.error, values)
    if not up:
        return Health(ERROR, "The inputs of the board are not all read.", values)
    return Health(WARN if notices else OK, " ".join(notices) or "The inputs of the board are read.", values)


def _together(told: Sequence[Health]) -> Health:
    """Return the worst level, with the texts of all that have this level."""
    level = max(each.level for each in told)
    texts = [each.message for each in told if each.level == level]
    return Health(level, " ".join(texts), {key: value for each in told for key, value in each.values.items()})


def _since(health: LinkHealth, at: int) -> str:
    return f"for {(at - (health.last_frame or health.since)) / 1e6:.1f} s"
