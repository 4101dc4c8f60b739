"""The device kind ``magnet``, and the keys of its stanza."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Literal, Self

from pydantic import Field, model_validator

from end_effector_hal.kinds import ChannelKey, DeviceKind
from end_effector_hal.kinds.conditions import part_conditions
from end_effector_hal.kinds.stanza import (
    NO_CHANNEL,
    Actuator,
    BlowOff,
    EvidenceConditions,
    Name,
    Settling,
    named,
    stanza_fault,
)
from end_effector_hal.signals import Kind
from end_effector_hal.vocabulary import TableState


class MagnetActuator(Actuator):
    """A magnet that holds while its line is active.

    A magnet that is switched off proves nothing: its remaining field may hold a part. A release is proven by the
    sensor of the part, and by `gone_bit` where it is named.
    """

    kind: Literal["magnet"] = Field(description="what it is")
    channel: Literal["none"] = Field(default="none", description="a magnet has no pressure sensor")
    part_bit: Name | None = Field(
        default=None,
        description="a part is gripped, by its flux or by the device's own word; one that is only near must not set it",
    )
    gone_bit: Name | None = Field(
        default=None,
        description="no part is at the magnet any more; null or none: part_bit off proves it",
    )
    blow_off: BlowOff | None = Field(
        default=None, description="air that pushes the part off when it is released; absent: none is fitted"
    )
    confirmed_ms: Settling = Field(default=50, description="part_bit for this long: confirmed")
    lost_ms: Settling = Field(default=40, description="once confirmed: part_bit off for this long: lost")
    gone_ms: Settling = Field(
        default=100, description="part_bit off, and gone_bit on where it is named, for this long: released"
    )

    @model_validator(mode="after")
    def _something_proves_it(self) -> Self:
        if self.evidence or named(self.part_bit):
            return self
        raise stanza_fault("EE-225", "nothing proves that it has gripped", "part_bit, or evidence")


class MagnetState(TableState):
    """States of a magnet."""

    OFF = 0
    PENDING_ON = 1
    ON = 2


class Magnet(DeviceKind[MagnetActuator]):
    """Kind of a magnet: confirmed and released by the sensor of its part, never by its line."""

    name = "magnet"
    stanza = MagnetActuator
    channels = (ChannelKey("part_bit", Kind.BIT, confirms=True), ChannelKey("gone_bit", Kind.BIT))
    states = MagnetState
    opposing = "blow_off"

    def preset(self, actuator: MagnetActuator) -> EvidenceConditions | None:
        """Return the conditions over the sensor of its part."""
        return part_conditions(actuator)

    def not_fitted(self, actuator: MagnetActuator, carried: Mapping[str, Kind]) -> Iterator[str]:
        """Yield a phrase if only ``part_bit`` confirms a release."""
        if actuator.gone_bit not in carried:
            proof = f"only {actuator.part_bit} off confirms a release"
            gone = actuator.gone_bit or NO_CHANNEL
            yield f"gone_bit: {gone}: {proof}: a part that only lost its grip is not detected"
