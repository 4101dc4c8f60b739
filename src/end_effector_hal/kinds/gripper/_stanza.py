"""The keys of a gripper."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import Field, model_validator

from end_effector_hal.kinds.stanza import (
    Actuator,
    BlowOff,
    MaybeMillimetres,
    Name,
    Settling,
    named,
    stanza_fault,
)


class GripperActuator(Actuator):
    """Fingers that an active line closes: pneumatic with a mono-stable valve, or electric with one line.

    A part is proven by its own switch, or by fingers that are neither open nor closed for `settle_ms`. At least
    `part_bit`, or `open_bit` and `closed_bit`, must be named.
    """

    kind: Literal["gripper"] = Field(description="what it is")
    channel: Literal["none"] = Field(default="none", description="a gripper has no pressure sensor")
    open_bit: Name | None = Field(
        default=None, description="end switch: the fingers are open; null or none: no such sensor"
    )
    closed_bit: Name | None = Field(
        default=None,
        description="end switch: the fingers have closed as far as they go, on nothing; null or none: no such sensor",
    )
    part_bit: Name | None = Field(
        default=None,
        description="a part is between the fingers, such as a switch set to its width; null or none: no such sensor",
    )
    blow_off: BlowOff | None = Field(
        default=None, description="air that pushes the part off when it is released; absent: none is fitted"
    )
    confirmed_ms: Settling = Field(
        default=50,
        description="part_bit for this long: confirmed; closed_bit for this long: closed on nothing",
    )
    settle_ms: Settling = Field(
        default=1000,
        description="without part_bit: neither open nor closed for this long, longer than any stroke: a part is held",
    )
    lost_ms: Settling = Field(
        default=40, description="a confirmed part is lost after its condition has not held for this long"
    )
    gone_ms: Settling = Field(
        default=50, description="open_bit for this long, or without it part_bit off: released"
    )
    stroke_mm: MaybeMillimetres = Field(
        default=None,
        description="from open to closed on the part, for joint_states and the URDF; null: no joint",
    )

    @model_validator(mode="after")
    def _something_proves_it(self) -> Self:
        if self.evidence or named(self.part_bit) or (named(self.open_bit) and named(self.closed_bit)):
            return self
        one = named(self.open_bit) or named(self.closed_bit)
        what = f"{one} alone proves no part" if one else "nothing proves that it has gripped"
        raise stanza_fault("EE-225", what, "part_bit, or open_bit and closed_bit, or evidence")
