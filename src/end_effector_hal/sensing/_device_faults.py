"""What devices say is wrong with them: bits and codes of their own, in the words of the description."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from end_effector_hal.description import Description, DeviceAlarm
from end_effector_hal.signals import ChannelReadings, Value
from end_effector_hal.vocabulary import Alarm, display_name


class DeviceFault(NamedTuple):
    """A fault that a device may show.

    Attributes:
        name: of its own: the channel, and the code where it has a text of its own.
        channel: that shows it.
        alarm: what the description says of it.
        code: the number that is shown; 1 of a bit.
    """

    name: str
    channel: str
    alarm: DeviceAlarm
    code: int

    @property
    def id(self) -> str:
        """Of its alarm."""
        return f"device.{self.alarm.severity}"

    @property
    def values(self) -> dict[str, str]:
        """Of the text of its alarm."""
        code = f", code {self.code}" if self.alarm.code is None and self.code != 1 else ""
        what = f"{self.alarm.text.rstrip('.')}{code}"
        return {"channel": display_name(self.channel), "what": what}

    def as_alarm(self, at: int = -1) -> Alarm:
        """The alarm that it is, from ``at`` µs on."""
        return Alarm(self.id, self.name, self.values, at)


class DeviceFaults:
    """Channels that are alarms; without a memory: what they show now.

    Args:
        description: the tool.
    """

    def __init__(self, description: Description) -> None:
        self._channels = {name: each for name, each in description.channels.items() if each.alarm}
        self._unproven = {
            name: frozenset(actuator for alarm in each.alarm for actuator in alarm.unproven)
            for name, each in self._channels.items()
        }

    @property
    def channels(self) -> tuple[str, ...]:
        """Their names."""
        return tuple(self._channels)

    def standing(self, readings: ChannelReadings, at: int) -> Iterator[DeviceFault]:
        """What is wrong at ``at`` µs by fresh readings."""
        for name in self._channels:
            value = readings.get(name, at)
            if value and (alarm := self._channels[name].alarm_of(value)):
                yield DeviceFault(_named(name, alarm), name, alarm, int(value))

    def shown(self, values: Mapping[str, Value], *, latching: bool) -> Iterator[str]:
        """Channels that show a fault among some values which refuses a grip, and latches or does not."""
        for name, each in self._channels.items():
            if (alarm := each.alarm_of(values.get(name))) and refuses(alarm, latching):
                yield name

    def named(self, name: str) -> DeviceFault | None:
        """A fault by its name; None: the description does not know it."""
        channel, _, code = name.partition(" ")
        alarms = self._channels[channel].alarm if channel in self._channels else ()
        alarm = next((each for each in alarms if _named(channel, each) == name), None)
        return DeviceFault(name, channel, alarm, int(code or 1)) if alarm else None

    def unknown(self, readings: ChannelReadings, at: int) -> tuple[str, ...]:
        """Channels without a fresh reading."""
        return tuple([name for name in self._channels if readings.get(name, at) is None])

    def unproven(self, readings: ChannelReadings, at: int) -> frozenset[str]:
        """Actuators whose sensors prove nothing: a fault says so, or its channel has no fresh reading."""
        found = [fault.alarm.unproven for fault in self.standing(readings, at)]
        lost = [self._unproven[name] for name in self.unknown(readings, at)]
        return frozenset().union(*found, *lost)

    def refusing(self, *, latching: bool | None = None) -> tuple[str, ...]:
        """Channels of which a fault can refuse a grip; ``latching``: with one that latches, or one that does not."""
        return tuple(
            name
            for name, each in self._channels.items()
            if any(refuses(alarm, latching) for alarm in each.alarm)
        )

    def well(self, readings: ChannelReadings, at: int, *, latching: bool) -> dict[str, bool]:
        """Of each of those channels that have a fresh reading whether it shows no such fault."""
        bad = {each.channel for each in self.standing(readings, at) if refuses(each.alarm, latching)}
        unknown = self.unknown(readings, at)
        return {name: name not in bad for name in self.refusing(latching=latching) if name not in unknown}


def _named(channel: str, alarm: DeviceAlarm) -> str:
    """Codes without a text of their own share a name: a device may show any number of them."""
    return channel if alarm.code is None else f"{channel} {alarm.code}"


def refuses(alarm: DeviceAlarm, latching: bool | None = None) -> bool:
    """Whether no grip begins while it stands; ``latching``: and it latches, or does not."""
    return alarm.severity == "error" and (latching is None or alarm.latches is latching)
