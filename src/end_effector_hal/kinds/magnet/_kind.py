"""A magnet as a kind of device."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from end_effector_hal.kinds import ChannelKey, DeviceKind
from end_effector_hal.kinds.conditions import part_conditions
from end_effector_hal.kinds.stanza import NO_CHANNEL, EvidenceConditions
from end_effector_hal.signals import Kind
from end_effector_hal.vocabulary import TableState

from ._stanza import MagnetActuator


class MagnetState(TableState):
    """A magnet."""

    OFF = 0
    PENDING_ON = 1
    ON = 2


class Magnet(DeviceKind[MagnetActuator]):
    """Confirmed and released by the sensor of its part, never by its line."""

    name = "magnet"
    stanza = MagnetActuator
    channels = (ChannelKey("part_bit", Kind.BIT, confirms=True), ChannelKey("gone_bit", Kind.BIT))
    states = MagnetState
    opposing = "blow_off"

    def preset(self, part: MagnetActuator) -> EvidenceConditions | None:
        """By the sensor of its part."""
        return part_conditions(part)

    def not_fitted(self, part: MagnetActuator, carried: Mapping[str, Kind]) -> Iterator[str]:
        """What proves a release."""
        if part.gone_bit not in carried:
            proof = f"only {part.part_bit} off confirms a release"
            yield f"gone_bit: {part.gone_bit or NO_CHANNEL}: {proof}: a part that only lost its grip is not detected"
