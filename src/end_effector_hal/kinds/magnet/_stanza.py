"""The keys of a magnet."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import Field, model_validator

from end_effector_hal.kinds.stanza import Actuator, BlowOff, Name, Settling, named, stanza_fault


class MagnetActuator(Actuator):
    """A magnet that holds while its line is active.

    That it is switched off proves nothing: what is left of its field may hold a part. A release is proven by the sensor
    of the part, and by `gone_bit` where there is one.
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
