"""Judges how far a frame can be trusted: impossible values, frozen sensors, a device that restarted."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

from end_effector_hal.codecs import Carrier, shows_noise
from end_effector_hal.description import Description
from end_effector_hal.kinds import COMPRESSED_AIR, kind_of
from end_effector_hal.signals import INLINE, NESTED, Frame, Kind, Value
from end_effector_hal.vocabulary import Alarm, to_us

from ._devices import devices_of
from .detectors import FrozenDetector


@dataclass(frozen=True, slots=True)
class Judged:
    """A frame after its judgement.

    Attributes:
        frame: the frame; its impossible or frozen values are invalid.
        doubted: channels whose reading proves nothing from now on; they are invalid in the frame.
        rebooted: channels of a device that restarted: their earlier readings are discarded.
    """

    frame: Frame
    doubted: frozenset[str] = frozenset()
    rebooted: frozenset[str] = frozenset()


class LinkRules:
    """Judges every frame before its values count; sans-IO, with a memory of doubted channels.

    Args:
        description: the tool; it defines the possible values of its channels.
        carrier: carries its channels.
        gap_us: length of a silence after which a sensor is judged from the beginning, µs.
    """

    MEMORY: ClassVar = {
        "_devices": INLINE,
        "_frozen": NESTED,
        "_doubts": dict[str, str],
    }

    def __init__(self, description: Description, carrier: Carrier, gap_us: int) -> None:
        self._devices = devices_of(description, carrier)
        kinds = carrier.channels
        ranges = {description.supply.channel: COMPRESSED_AIR}
        ranges |= {
            actuator.channel: kind_of(actuator).plausible(actuator) for _, actuator in description.ordered
        }
        self._ranges = {
            channel: span for channel, span in ranges.items() if kinds.get(channel) is Kind.PRESSURE
        }
        self._limits = {channel: span.limits_pa for channel, span in self._ranges.items()}
        self._frozen = {
            channel: FrozenDetector(to_us(after_s), gap_us)
            for channel, after_s in frozen_after(description, carrier).items()
        }
        self._doubts: dict[str, str] = {}

    @property
    def reboots(self) -> int:
        """Number of restarts of devices."""
        return self._devices.reboots

    def judge(self, frame: Frame) -> Judged:
        """Return the frame with its doubted values marked as invalid."""
        rebooted = self._devices.rebooted(frame)
        if mixed := self._devices.mixed(frame.at) & frame.values.keys():
            return Judged(replace(frame, values=dict.fromkeys(frame.values)), frozenset(mixed), rebooted)
        doubts: dict[str, str] = {}
        limits, frozen = self._limits, self._frozen
        for channel, value in frame.values.items():
            if value is None or isinstance(value, bool):
                continue
            if channel in limits and not limits[channel][0] <= value <= limits[channel][1]:
                doubts[channel] = self._ranges[channel].fault(channel, value)
            elif channel in frozen and frozen[channel].sample(value, frame.at):
                doubts[channel] = _frozen(channel)
        if not (doubts or self._doubts):
            return Judged(frame, rebooted=rebooted)
        # A doubt is told in the words of its beginning: it does not flicker.
        kept = {channel: why for channel, why in self._doubts.items() if channel not in frame.values}
        self._doubts = kept | {channel: self._known(channel, why) for channel, why in doubts.items()}
        if not doubts:
            return Judged(frame, rebooted=rebooted)
        values: Mapping[str, Value] = frame.values
        values = {channel: None if channel in doubts else value for channel, value in values.items()}
        return Judged(replace(frame, values=values), frozenset(doubts), rebooted)

    def mixed(self, at: int) -> frozenset[str]:
        """Return the channels of links on which two devices send."""
        return self._devices.mixed(at)

    def notices(self, at: int) -> tuple[Alarm, ...]:
        """Return the alarms about channels and devices that are doubted now."""
        if not self._doubts:
            return self._devices.notices(at)
        doubts = [Alarm("channel.doubted", name, {"text": why}) for name, why in self._doubts.items()]
        return (*doubts, *self._devices.notices(at))

    def deadline(self, at: int) -> int | None:
        """Return the time at which an alarm ends by itself, µs; None: there is none."""
        return self._devices.deadline(at)

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
