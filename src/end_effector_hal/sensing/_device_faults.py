"""Faults that devices report by their own bits and codes, in the words of the description."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from end_effector_hal.description import Description, DeviceAlarm
from end_effector_hal.signals import Value
from end_effector_hal.vocabulary import Alarm, display_name

from ._readings import Readings


class DeviceFault(NamedTuple):
    """A fault that a device may report.

    Attributes:
        name: name of the fault: the channel, and the code if the code has its own text.
        channel: the channel that reports it.
        alarm: the stanza of the description about it.
        code: the reported number; 1 for a bit.
    """

    name: str
    channel: str
    alarm: DeviceAlarm
    code: int

    @property
    def id(self) -> str:
        """Id of the fault's alarm."""
        return f"device.{self.alarm.severity}"

    @property
    def values(self) -> dict[str, str]:
        """Values for the text of the fault's alarm."""
        code = f", code {self.code}" if self.alarm.code is None and self.code != 1 else ""
        what = f"{self.alarm.text.rstrip('.')}{code}"
        return {"channel": display_name(self.channel), "what": what}

    def as_alarm(self, at: int = -1) -> Alarm:
        """Return the fault as an alarm that begins at ``at`` µs."""
        return Alarm(self.id, self.name, self.values, at)


_Judged = tuple[tuple[DeviceFault, ...], tuple[str, ...]]
"""The present faults, and the channels without a fresh reading."""


class DeviceFaults:
    """The channels that are alarms of devices. The present readings are judged once, however often somebody asks.

    Args:
        description: the tool.
    """

    def __init__(self, description: Description) -> None:
        self.channels = {name: each for name, each in description.channels.items() if each.alarm}
        """The channels, by name."""
        self._unproven = {
            name: frozenset(actuator for alarm in each.alarm for actuator in alarm.unproven)
            for name, each in self.channels.items()
        }
        self._judged: tuple[object, int, _Judged] = None, 0, ((), ())

    def standing(self, readings: Readings, at: int) -> tuple[DeviceFault, ...]:
        """Return the faults that fresh readings show at ``at`` µs."""
        return self._judge(readings, at)[0]

    def shown(self, values: Mapping[str, Value], *, latching: bool) -> Iterator[str]:
        """Yield the channels whose value shows a fault that prevents a grip.

        ``latching`` selects faults that latch, or those that do not.
        """
        for name, each in self.channels.items():
            if (alarm := each.alarm_of(values.get(name))) and refuses(alarm, latching):
                yield name

    def named(self, name: str) -> DeviceFault | None:
        """Return a fault by its name; None: the description does not declare it."""
        channel, _, code = name.partition(" ")
        alarms = self.channels[channel].alarm if channel in self.channels else ()
        alarm = next((each for each in alarms if _named(channel, each) == name), None)
        return DeviceFault(name, channel, alarm, int(code or 1)) if alarm else None

    def unknown(self, readings: Readings, at: int) -> tuple[str, ...]:
        """Return the channels without a fresh reading."""
        return self._judge(readings, at)[1]

    def unproven(self, readings: Readings, at: int) -> frozenset[str]:
        """Return the actuators whose sensors prove nothing.

        The reason is a fault, or a channel without a fresh reading.
        """
        found = [fault.alarm.unproven for fault in self.standing(readings, at)]
        lost = [self._unproven[name] for name in self.unknown(readings, at)]
        return frozenset().union(*found, *lost)

    def refusing(self, *, latching: bool | None = None) -> tuple[str, ...]:
        """Return the channels with a fault that can prevent a grip.

        ``latching`` selects faults that latch, or those that do not; None: all.
        """
        return tuple(
            name
            for name, each in self.channels.items()
            if any(refuses(alarm, latching) for alarm in each.alarm)
        )

    def well(self, readings: Readings, at: int, *, latching: bool) -> dict[str, bool]:
        """Return by channel whether its fresh reading shows no fault that prevents a grip.

        ``latching`` selects faults that latch, or those that do not. Channels without a fresh reading are left out.
        """
        bad = {each.channel for each in self.standing(readings, at) if refuses(each.alarm, latching)}
        unknown = self.unknown(readings, at)
        return {name: name not in bad for name in self.refusing(latching=latching) if name not in unknown}

    def _judge(self, readings: Readings, at: int) -> _Judged:
        of, asked_at, found = self._judged
        if of is readings.read_at and asked_at == at:
            return found
        standing, unknown = list[DeviceFault](), list[str]()
        for name, each in self.channels.items():
            if (value := readings.get(name, at)) is None:
                unknown.append(name)
            elif value and (alarm := each.alarm_of(value)):
                standing.append(DeviceFault(_named(name, alarm), name, alarm, int(value)))
        found = tuple(standing), tuple(unknown)
        self._judged = readings.read_at, at, found
        return found


def _named(channel: str, alarm: DeviceAlarm) -> str:
    """Return the name of a fault.

    Codes without their own text share a name, because a device may have any number of them.
    """
    return channel if alarm.code is None else f"{channel} {alarm.code}"


def refuses(alarm: DeviceAlarm, latching: bool | None = None) -> bool:
    """Return whether an alarm prevents a grip; ``latching``: and also latches, or does not."""
    return alarm.severity == "error" and (latching is None or alarm.latches is latching)
