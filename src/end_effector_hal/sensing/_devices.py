"""The devices that send the frames: whether one restarted."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from end_effector_hal.codecs import Carrier, FrameSource, sequence_of, sources_of
from end_effector_hal.description import Description
from end_effector_hal.signals import PART, Frame
from end_effector_hal.vocabulary import Alarm

SAID_US = 10_000_000
"""So long a reboot of a device is told."""
AGAIN_US, MIXED = 1_000_000, 3
"""So many restarts, each so soon after the one before, are those of no device: another one sends on the same wire."""


class SendingDevice:
    """The only one, or that of one link.

    Args:
        channels: what it sends.
        sequence: bits of its sequence number, and of its clock.
        name: for a sentence.
    """

    MEMORY: ClassVar = {"_sequence": PART, "_rebooted_at": int | None, "_quick": int}

    def __init__(self, channels: frozenset[str], sequence: tuple[int, int], name: str) -> None:
        self._channels, self._name = channels, name
        self._sequence = sequence_of(*sequence)
        self._rebooted_at: int | None = None
        self._quick = 0

    @property
    def reboots(self) -> int:
        """How often it restarted."""
        return self._sequence.reboots

    def rebooted(self, frame: Frame) -> frozenset[str]:
        """Its channels where a frame shows that it restarted; else none."""
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
        """Its channels while two devices send on the link, so that no reading is known to be whose; else none."""
        recent = self._rebooted_at is not None and at - self._rebooted_at < AGAIN_US
        return self._channels if recent and self._quick >= MIXED else frozenset()

    def notices(self, at: int) -> tuple[Alarm, ...]:
        """The alarm that it has restarted lately."""
        if self._rebooted_at is None or at - self._rebooted_at >= SAID_US:
            return ()
        if self._quick >= MIXED:
            return (Alarm("link.two_senders", self._name),)
        return (Alarm("link.restarted", self._name, {"again": " again" * (self.reboots > 1)}),)

    def deadline(self, at: int) -> int | None:
        """µs at which a notice ends by itself."""
        end = None if self._rebooted_at is None else self._rebooted_at + SAID_US
        return end if end is not None and end > at else None


class SendingDevices:
    """Those of several links; a frame is of the one that sends its channels.

    Args:
        devices: by the names of their links.
        links: and these by their channels.
    """

    MEMORY: ClassVar = {"_devices": PART}

    def __init__(self, devices: Mapping[str, SendingDevice], links: Mapping[str, str]) -> None:
        self._devices, self._links = dict(devices), links

    @property
    def reboots(self) -> int:
        """How often one of them restarted."""
        return sum(device.reboots for device in self._devices.values())

    def rebooted(self, frame: Frame) -> frozenset[str]:
        """The channels of the one that restarted; else none."""
        link = self._links.get(next(iter(frame.values), ""))
        return self._devices[link].rebooted(frame) if link else frozenset()

    def mixed(self, at: int) -> frozenset[str]:
        """The channels of links on which two devices send."""
        return frozenset().union(*(device.mixed(at) for device in self._devices.values()))

    def notices(self, at: int) -> tuple[Alarm, ...]:
        """The alarms of the devices that restarted recently."""
        return tuple(said for device in self._devices.values() for said in device.notices(at))

    def deadline(self, at: int) -> int | None:
        """µs at which the next notice ends by itself."""
        ends = (device.deadline(at) for device in self._devices.values())
        return min((end for end in ends if end is not None), default=None)


def devices_of(description: Description, carrier: Carrier) -> SendingDevice | SendingDevices:
    """New ones."""
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
