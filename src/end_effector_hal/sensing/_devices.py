"""The devices that send the frames: detects whether one of them restarted."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from end_effector_hal.codecs import Carrier, FrameSource, sequence_of, sources_of
from end_effector_hal.description import Description
from end_effector_hal.signals import NESTED, Frame
from end_effector_hal.vocabulary import Alarm

SAID_US = 10_000_000
"""Time for which the restart of a device is reported, µs."""
AGAIN_US, MIXED = 1_000_000, 3
"""MIXED restarts, each less than AGAIN_US µs after the one before, mean two devices on one wire.

After so many, a second device sends on the same wire.
"""


class SendingDevice:
    """Detects restarts of the only device, or of the device on one link.

    Args:
        channels: the channels that it sends.
        sequence: number of bits of its sequence number, and of its clock.
        name: the device in a sentence.
    """

    MEMORY: ClassVar = {"_sequence": NESTED, "_rebooted_at": int | None, "_quick": int}

    def __init__(self, channels: frozenset[str], sequence: tuple[int, int], name: str) -> None:
        self._channels, self._name = channels, name
        self._sequence = sequence_of(*sequence)
        self._rebooted_at: int | None = None
        self._quick = 0

    @property
    def reboots(self) -> int:
        """Number of restarts."""
        return self._sequence.reboots

    def rebooted(self, frame: Frame) -> frozenset[str]:
        """Return the device's channels if a frame shows that it restarted; else none."""
        if frame.seq is None or frame.device_ms is None:
            return frozenset()
        before = self._sequence.reboots
        self._sequence.is_new(frame.seq, frame.device_ms)
        if self._sequence.reboots == before:
            return frozenset()
        again = self._rebooted_at is not None and frame.at - self._rebooted_at < AGAIN_US
        self._quick = self._quick + 1 if again else 1
        self._rebooted_at = frame.at
        return self._channels

    def mixed(self, at: int) -> frozenset[str]:
        """Return its channels while two devices send on the link, so that readings have no known origin."""
        recent = self._rebooted_at is not None and at - self._rebooted_at < AGAIN_US
        return self._channels if recent and self._quick >= MIXED else frozenset()

    def notices(self, at: int) -> tuple[Alarm, ...]:
        """Return the alarm about a recent restart, if any."""
        if self._rebooted_at is None or at - self._rebooted_at >= SAID_US:
            return ()
        if self._quick >= MIXED:
            return (Alarm("link.two_senders", self._name),)
        return (Alarm("link.restarted", self._name, {"again": " again" * (self.reboots > 1)}),)

    def deadline(self, at: int) -> int | None:
        """Return the time at which the alarm ends by itself, µs; None: there is none."""
        end = None if self._rebooted_at is None else self._rebooted_at + SAID_US
        return end if end is not None and end > at else None


class SendingDevices:
    """The devices of several links; a frame belongs to the device that sends its channels.

    Args:
        devices: devices by the names of their links.
        links: names of the links by their channels.
    """

    MEMORY: ClassVar = {"_devices": NESTED}

    def __init__(self, devices: Mapping[str, SendingDevice], links: Mapping[str, str]) -> None:
        self._devices, self._links = dict(devices), links

    @property
    def reboots(self) -> int:
        """Number of restarts of all devices."""
        return sum(device.reboots for device in self._devices.values())

    def rebooted(self, frame: Frame) -> frozenset[str]:
        """Return the channels of the device whose restart the frame shows; else none."""
        link = self._links.get(next(iter(frame.values), ""))
        return self._devices[link].rebooted(frame) if link else frozenset()

    def mixed(self, at: int) -> frozenset[str]:
        """Return the channels of links on which two devices send."""
        return frozenset().union(*(device.mixed(at) for device in self._devices.values()))

    def notices(self, at: int) -> tuple[Alarm, ...]:
        """Return the alarms of the devices that restarted recently."""
        return tuple(said for device in self._devices.values() for said in device.notices(at))

    def deadline(self, at: int) -> int | None:
        """Return the time at which the next alarm ends by itself, µs; None: there is none."""
        ends = (device.deadline(at) for device in self._devices.values())
        return min((end for end in ends if end is not None), default=None)


def devices_of(description: Description, carrier: Carrier) -> SendingDevice | SendingDevices:
    """Return new objects for the devices of a tool."""
    sources = [source for source in sources_of(carrier) if source.link]
    if not sources:
        (first, *_) = sources_of(carrier)
        return SendingDevice(frozenset(carrier.channels), first.sequence, "device that reads the sensors")
    devices = {source.link: _device(description, source) for source in sources if source.link}
    return SendingDevices(
        devices, {name: source.link for source in sources if source.link for name in source.channels}
    )


def _device(description: Description, source: FrameSource) -> SendingDevice:
    name = f"device on the {description.link_name(source.link or '')}"
    return SendingDevice(source.channels, source.sequence, name)
