"""The keys of a vacuum.

The defaults are those of the paper's tool, and of Schmalz's data sheets where the paper has no value.
"""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from end_effector_hal.kinds.stanza import (
    Actuator,
    BelowAmbient,
    BlowOff,
    Name,
    Samples,
    Settling,
)


class VacuumActuator(Actuator):
    """A vacuum generator with its cups, proven by pressure or by switches (`part_bit`, `gone_bit`)."""

    kind: Literal["vacuum"] = Field(description="what it is")
    blow_off: BlowOff | None = Field(default=None, description="absent: none is fitted")
    confirmed_kpa: BelowAmbient = Field(
        default=55.0, description="at least this far below ambient: confirmed"
    )
    confirmed_samples: Samples = Field(default=3, description="consecutive samples that confirm")
    gone_kpa: BelowAmbient = Field(default=10.0, description="less than this: gone")
    lost_kpa: BelowAmbient = Field(default=50.0, description="less than this, once confirmed: lost")
    lost_samples: Samples = Field(
        default=2, description="consecutive samples below lost_kpa that count as lost"
    )
    lost_at_once_kpa: BelowAmbient = Field(
        default=20.0, description="less than this, once confirmed: lost at once"
    )
    secure_kpa: BelowAmbient = Field(default=75.0, description="at least this: a secure grip")
    secure_hysteresis_kpa: BelowAmbient = Field(
        default=15.0, description="no longer secure this far below secure_kpa"
    )
    part_bit: Name | None = Field(
        default=None,
        description="vacuum switch that is on with a part; it decides, whatever channel shows; null: none",
    )
    gone_bit: Name | None = Field(
        default=None,
        description="with part_bit: switch that is on without vacuum; null or none: part_bit off proves a release",
    )
    confirmed_ms: Settling = Field(default=50, description="part_bit for this long: confirmed")
    lost_ms: Settling = Field(default=40, description="once confirmed: part_bit off for this long: lost")
    gone_ms: Settling = Field(
        default=100, description="part_bit off, and gone_bit on where it is named, for this long: gone"
    )
