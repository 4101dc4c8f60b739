"""Judges how far a frame can be trusted: impossible values, frozen sensors, a device that restarted."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar

from end_effector_hal.codecs import Carrier, shows_noise
from end_effector_hal.description import Description
from end_effector_hal.kinds import COMPRESSED_AIR, kind_of
from end_effector_hal.signals import NESTED, Frame, Kind, Value
from end_effector_hal.vocabulary import Alarm, to_us

from ._devices import NO_CHANNELS, SAID_US, devices_of, links_of


class LastMove:
    """The last change of a channel's value: the noise of a working sensor changes its value."""

    MEMORY: ClassVar = {"value": int | None, "since": int, "last": int}

    def __init__(self, after_us: int) -> None:
        self.after_us = after_us
        """Time after which a constant value counts as frozen, µs."""
        self.value: int | None = None
        self.since = self.last = 0
        """Time of the first and of the last sample with this value, µs."""


class LinkRules:
    """Judges every frame before its values count; sans-IO, with a memory of doubted channels.

    Args:
        description: the tool; it defines the possible values of its channels.
        carrier: carries its channels.
        gap_us: length of a silence after which a sensor is judged from the beginning, µs.
    """

    MEMORY: ClassVar = {
        "_devices": NESTED,
        "_frozen": NESTED,
        "_doubts": dict[str, str],
    }

    def __init__(self, description: Description, carrier: Carrier, gap_us: int) -> None:
        self._devices, self._links = devices_of(description, carrier), links_of(carrier)
        ranges = {description.supply.channel: COMPRESSED_AIR}
        ranges |= {
            actuator.channel: kind_of(actuator).plausible(actuator) for _, actuator in description.ordered
        }
        self._ranges = {
            channel: ranges[channel]
            for channel, kind in carrier.channels.items()
            if kind is Kind.PRESSURE and channel in ranges
        }
        self._limits = {channel: span.limits_pa for channel, span in self._ranges.items()}
        self._gap_us = gap_us
        self._frozen = {
            channel: LastMove(to_us(after_s))
            for channel, after_s in frozen_after(description, carrier).items()
        }
        self._doubts: dict[str, str] = {}

    def judge(self, frame: Frame) -> tuple[Frame, frozenset[str], frozenset[str]]:
        """Return the frame, with impossible and frozen values marked as invalid, and two sets of channels.

        The first are these doubted channels, which prove nothing from now on. The second are the channels of a device
        that restarted: their earlier readings are discarded.
        """
        rebooted = NO_CHANNELS
        if device := self._devices.get(self._links.get(next(iter(frame.values), ""), "")):
            rebooted = device.rebooted(frame)
            if mixed := device.mixed(frame.at) & frame.values.keys():
                return replace(frame, values=dict.fromkeys(frame.values)), frozenset(mixed), rebooted
        doubts: dict[str, str] = {}
        read, frozen, at = frame.values.get, self._frozen, frame.at
        for channel, (low, high) in self._limits.items():
            if type(value := read(channel)) is not int:  # invalid, not in this frame, or a bit
                continue
            if not low <= value <= high:
                doubts[channel] = self._ranges[channel].fault(channel, value)
            elif (move := frozen.get(channel)) is not None:
                if value != move.value or at - move.last >= self._gap_us:  # after a gap it starts again
                    move.value, move.since = value, at
                move.last = at
                if at - move.since >= move.after_us:
                    doubts[channel] = _frozen(channel)
        if not (doubts or self._doubts):
            return frame, NO_CHANNELS, rebooted
        # A doubt is told in the words of its beginning: it does not flicker.
        kept = {channel: why for channel, why in self._doubts.items() if channel not in frame.values}
        self._doubts = kept | {channel: self._known(channel, why) for channel, why in doubts.items()}
        if not doubts:
            return frame, NO_CHANNELS, rebooted
        values: Mapping[str, Value] = frame.values
        values = {channel: None if channel in doubts else value for channel, value in values.items()}
        return replace(frame, values=values), frozenset(doubts), rebooted

    def notices(self, at: int) -> tuple[Alarm, ...]:
        """Return the alarms about channels and devices that are doubted now."""
        said = [Alarm("channel.doubted", name, {"text": why}) for name, why in self._doubts.items()]
        for device in self._devices.values():
            if device.rebooted_at is not None:
                said += device.notices(at)
        return tuple(said)

    def mixed(self, at: int) -> frozenset[str]:
        """Return the channels of links on which two devices send."""
        return NO_CHANNELS.union(*[device.mixed(at) for device in self._devices.values()])

    def deadline(self, at: int) -> int | None:
        """Return the time at which an alarm ends by itself, µs; None: there is none."""
        due = None
        for device in self._devices.values():
            if device.rebooted_at is not None and at < (end := device.rebooted_at + SAID_US):
                due = end if due is None else min(due, end)
        return due

    def _known(self, channel: str, why: str) -> str:
        before = self._doubts.get(channel, "")
        same_kind = (why == _frozen(channel)) == (before == _frozen(channel))
        return before if before and same_kind else why


def frozen_after(description: Description, carrier: Carrier) -> dict[str, float]:
    """Return by channel the seconds after which a constant value counts as frozen.

    Only pressures with ``frozen_s`` that are carried finely enough are included.
    """
    if not shows_noise(carrier):
        return {}
    declared = {actuator.channel: actuator.frozen_s for _, actuator in description.ordered}
    declared[description.supply.channel] = description.supply.frozen_s
    kinds = carrier.channels
    return {
        channel: after_s
        for channel, after_s in declared.items()
        if after_s is not None and kinds.get(channel) is Kind.PRESSURE
    }


def _frozen(channel: str) -> str:
    return (
        f"The channel {channel} has not moved by a single count: its sensor is frozen, and its value counts as "
        "invalid. Is it broken? Does the device filter what it sends (frozen_s)?"
    )
