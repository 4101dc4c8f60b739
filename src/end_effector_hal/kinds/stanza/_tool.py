"""What all actuators of a tool share: its compressed air, and the watch over a held part."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from ._part import Kilopascal, MaybeSeconds, Name, Part, Seconds


class Supply(Part):
    """The compressed-air supply (IL-06)."""

    channel: Name = Field(default="supply", description="pressure channel of the link; none: no such sensor")
    nominal_kpa: Kilopascal = Field(default=600.0, description="taken where its channel is none")
    warn_kpa: Kilopascal = Field(default=450.0, description="less than this: a warning")
    refuse_kpa: Kilopascal = Field(default=400.0, description="less than this: a new grip is refused")
    hysteresis_kpa: Kilopascal = Field(default=20.0, description="granted again this far above refuse_kpa")
    frozen_s: MaybeSeconds = Field(
        default=None,
        description="a pressure that does not move by a count for so long is invalid; null: never",
    )


class Hold(Part):
    """What is watched while a part is held; it warns, and never releases anything."""

    secure_within_s: Seconds = Field(
        default=2.0, description="a vacuum that is not secure so long after GRIPPED: a weak grip"
    )
    trend_s: Seconds = Field(default=2.0, description="a vacuum is judged over this long for a leak")
    warn_ahead_s: Seconds = Field(
        default=10.0, description="a vacuum that would be lost within this, as it falls now: a leak"
    )
    lift_needs: Literal["confirmed", "secure"] = Field(
        default="confirmed", description="secure: lift_allowed also waits for secure_kpa; else a warning only"
    )
