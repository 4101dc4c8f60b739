"""The keys of a cylinder; the defaults are those of the paper's tool."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from end_effector_hal.kinds.stanza import Actuator, Kilopascal, MaybeMillimetres, Name, Seconds


class CylinderActuator(Actuator):
    """A pneumatic cylinder, single-acting with spring return or driven by a mono-stable valve."""

    kind: Literal["cylinder"] = Field(description="what it is")
    extended_fraction: Annotated[float, Field(gt=0, le=1)] = Field(
        default=0.85, description="at least this share of the supply pressure: extended"
    )
    extended_s: Seconds = Field(default=0.1, description="for at least this long")
    retracted_kpa: Kilopascal = Field(default=50.0, description="less than this: retracted")
    retracted_s: Seconds = Field(default=0.2, description="for at least this long")
    extended_bit: Name | None = Field(
        default="cylinder_extended", description="position bit that proves extended; none: no such sensor"
    )
    retracted_bit: Name | None = Field(
        default="cylinder_retracted", description="position bit that proves retracted; none: no such sensor"
    )
    stroke_mm: MaybeMillimetres = Field(
        default=None, description="from retracted to extended, for joint_states and the URDF; null: no joint"
    )
