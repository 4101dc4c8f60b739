"""The devices that send the frames: detects whether one of them restarted."""

from __future__ import annotations

from typing import ClassVar

from end_effector_hal.codecs import Carrier, FrameSource, Sequence, sources_of
from end_effector_hal.description import Description
from end_effector_hal.signals import NESTED, Frame
from end_effector_hal.vocabulary import Alarm

SAID_US = 10_000_000
"""Time for which the restart of a device is reported, µs."""
NO_CHANNELS: frozenset[str] = frozenset()
AGAIN_US, MIXED = 1_000_000, 3
"""MIXED restarts, each less than AGAIN_US µs after the one before, mean two devices on one wire.

After so many, a second device sends on the same wire.
"""


class SendingDevice:
    """Detects restarts of the only device, or of the device on one link.

    Args:
        channels: the channels that it sends.
        name: the device in a sentence.
    """

    MEMORY: ClassVar = {"_sequence": NESTED, "rebooted_at": int | None, "_quick": int}

    def __init__(self, channels: frozenset[str], name: str) -> None:
        self._channels, self._name = channels, name
        self._sequence = Sequence()
        self.rebooted_at: int | None = None
        """Time of the last restart, µs; None: there was none."""
        self._quick = 0

    def rebooted(self, frame: Frame) -> frozenset[str]:
        """Return the device's channels if a frame shows that it restarted; else none."""
        if frame.seq is None or frame.device_ms is None:
            return NO_CHANNELS
        before = self._sequence.reboots
        self._sequence.is_new(frame.seq, frame.device_ms)
        if self._sequence.reboots == before:
            return NO_CHANNELS
        again = self.rebooted_at is not None and frame.at - self.rebooted_at < AGAIN_US
        self._quick = self._quick + 1 if again else 1
        self.rebooted_at = frame.at
        return self._channels

    def mixed(self, at: int) -> frozenset[str]:
        """Return its channels while two devices send on the link, so that readings have no known origin."""
        recent = self.rebooted_at is not None and at - self.rebooted_at < AGAIN_US
        return self._channels if recent and self._quick >= MIXED else NO_CHANNELS

    def notices(self, at: int) -> tuple[Alarm, ...]:
        """Return the alarm about a recent restart, if any."""
        if self.rebooted_at is None or at - self.rebooted_at >= SAID_US:
            return ()
        if self._quick >= MIXED:
            return (Alarm("link.two_senders", self._name),)
        return (Alarm("link.restarted", self._name, {"again": " again" * (self._sequence.reboots > 1)}),)


def devices_of(description: Description, carrier: Carrier) -> dict[str, SendingDevice]:
    """Return new objects for the devices of a tool, by the names of their links; "": the only device."""
    sources = sources_of(carrier)
    found = {source.link: _device(description, source) for source in sources if source.link}
    alone = SendingDevice(frozenset(carrier.channels), "device that reads the sensors")
    return found or {"": alone}


def links_of(carrier: Carrier) -> dict[str, str]:
    """Return the names of the links by their channels; "": the only link, or the board."""
    return {name: source.link or "" for source in sources_of(carrier) for name in source.channels}


def _device(description: Description, source: FrameSource) -> SendingDevice:
    name = f"device on the {description.link_name(source.link or '')}"
    return SendingDevice(source.channels, name)
