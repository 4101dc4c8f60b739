"""Node Pressure: the pressures of the sensors, in Pa, and the state of the sensor links."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Sequence
from dataclasses import replace

from end_effector_hal.control import Status
from end_effector_hal.description import Description
from end_effector_hal.runtime import silent_links
from end_effector_hal.sensing import JudgedReadings
from end_effector_hal.signals import Value
from end_effector_hal.wires import now_us
from end_effector_hal.wires.inputs import InputsHealth
from end_effector_hal.wires.link import LinkHealth, LinkState
from end_effector_hal.wires.sensors import SensorHealth

from .interface import FRAME_ID, PRESSURE, pressure_topics
from .report import ERROR, OK, WARN, Health, publish_health, silence
from .transport import AMBIENT_PA, MessageHeader, NodeTransport, PressureMessage

_OF_READINGS = ("channel.", "device.", "evidence.", "link.restarted", "link.two_senders", "stamps.")
"""Beginnings of the ids of alarms about readings."""


class PressureNode:
    """Publishes a pressure with each frame that has read it.

    A pressure that is invalid, doubted or stale is NaN, never the last value; NaN is published once.
    """

    def __init__(self, node: NodeTransport) -> None:
        self._log, self._tool = node.log, node.tool()
        description = self._tool.description
        self._frame_id = node.parameter(FRAME_ID) or f"{description.name}_link"
        self._pressures = {channel: node.publisher(topic) for channel, topic in pressure_topics(description)}
        self._unknown: set[str] = set()
        """Pressures whose last published value is NaN."""
        self._logged: dict[str, str] = {}
        """The last line in the log about each source."""
        self._tool.subscribe_readings(self._on_readings, name=PRESSURE, key=self._frame_for_readers)
        where = ", ".join(link.port for link in description.links.values())
        publish_health(node, description.name, self._health, hardware=where or description.sensors)

    def _frame_for_readers(self, readings: JudgedReadings) -> int:
        """Return a number for each frame; a constant while no pressure is read."""
        return readings.at if any(publish.is_read() for publish in self._pressures.values()) else 0

    def _on_readings(self, readings: JudgedReadings) -> None:
        header = MessageHeader(readings.at, self._frame_id)
        for channel in self._pressures:
            value = readings.values.get(channel)
            if value is None and channel not in self._unknown:
                self._unknown.add(channel)
                self._pressures[channel](PressureMessage(absolute_pa(None), header))
            elif value is not None and (channel in readings.sampled or channel in self._unknown):
                self._unknown.discard(channel)
                self._pressures[channel](PressureMessage(absolute_pa(value), header))

    def _health(self) -> Health:
        if silent := silence(self._tool):
            return silent
        status, sensors = self._tool.status, self._tool.sensors
        self._log_changes(sensors)
        told = list(_sources(self._tool.description, status, sensors))
        if not told:
            return Health(WARN, "The HAL has not reported the state of its sensors yet.")
        found = told[0] if len(told) == 1 else _together(told)
        return replace(found, values={**found.values, "ambient added (Pa)": AMBIENT_PA})

    def _log_changes(self, sensors: SensorHealth) -> None:
        for name, (level, line) in _lines(self._tool.description, sensors).items():
            if line != self._logged.get(name):
                self._logged[name] = line
                self._log.log(level, "%s", line)


def absolute_pa(value: Value) -> float:
    """Return the absolute pressure of a gauge pressure, Pa; NaN if it is invalid, or a bit."""
    return float("nan") if value is None or isinstance(value, bool) else float(AMBIENT_PA + value)


def _lines(description: Description, sensors: SensorHealth) -> dict[str, tuple[int, str]]:
    """Return the level and the text of a line of the log for each source."""
    found: dict[str, tuple[int, str]] = {}
    for name, link in sensors.links.items():
        source = description.link_name(name) if name else "sensor link"
        state = " ".join((f"the {source} is {link.state.value}", *link.faults))
        found[name] = (logging.ERROR, link.error) if link.error else (logging.INFO, state)
    if inputs := sensors.inputs:
        state = "the inputs of the board are read"
        found["inputs of the board"] = (
            (logging.ERROR, inputs.error) if inputs.error else (logging.INFO, state)
        )
    return found


def _sources(description: Description, status: Status, sensors: SensorHealth) -> Iterator[Health]:
    """Yield the health of each source; the first one has the alarms about readings."""
    at, silent = now_us(), silent_links(description, status, sensors.links)
    notices = [str(each) for each in status.alarms if not each.over and each.id.startswith(_OF_READINGS)]
    for name, link in sensors.links.items():
        yield _of_link(link, at, (*notices, *link.faults), up=name not in silent, name=name)
        notices = []
    if sensors.inputs:
        yield _of_inputs(sensors.inputs, notices, up=status.link_up or bool(sensors.links))


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
