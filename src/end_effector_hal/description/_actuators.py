"""The actuators of a gripping sequence.

Defaults are those of the paper's tool, and of Schmalz's data sheets where the paper is silent.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from ._endings import OwnEndings
from ._part import Kilopascal, LineName, MaybeSeconds, Name, Part, RosName, Samples, Seconds, Vacuum, Word


class ActuatorPart(Part):
    """What every actuator has: a line that drives it, a channel that proves it, and its times."""

    line: LineName = Field(description="name of the GPIO line, as gpioinfo shows it")
    pin: Word = Field(default="", description="where it is found on the board; for people")
    channel: Name = Field(
        description="pressure channel of the link that proves it; of a cylinder with a bit also none: no such sensor"
    )
    timeout_s: Seconds = Field(default=5.0, description="not confirmed within: one failed attempt")
    reset_s: Seconds = Field(default=1.0, description="inactive between two attempts")
    attempts: Annotated[int, Field(ge=1, le=20)] = Field(default=3, description="failed attempts that abort")
    release_s: Seconds = Field(default=2.0, description="longest wait for the feedback to be gone")
    frozen_s: MaybeSeconds = Field(
        default=None,
        description="a pressure that does not move by a count for so long is invalid; null: never",
    )
    endings: OwnEndings = Field(
        default=OwnEndings(), description="what each ending does to this one; default: as for the whole tool"
    )
    service: RosName | None = Field(default=None, description="ROS service; default: Set + name in CamelCase")
    topic: RosName | None = Field(
        default=None, description="ROS topic; default: Pressure + name in CamelCase"
    )


class BlowOff(Part):
    """A blow-off valve on a vacuum circuit (IL-08). The line arbiter guards it; no automaton drives it."""

    line: LineName = Field(description="name of the GPIO line; active means blowing")
    gap_s: Seconds = Field(
        default=0.05, description="IL-08: between the end of suction and blowing, and back"
    )


class VacuumActuator(ActuatorPart):
    """A vacuum generator with its cups."""

    kind: Literal["vacuum"] = Field(description="what it is")
    blow_off: BlowOff | None = Field(default=None, description="absent: none is fitted")
    confirmed_kpa: Vacuum = Field(default=55.0, description="at least this far below ambient: confirmed")
    confirmed_samples: Samples = Field(default=3, description="consecutive samples that confirm")
    gone_kpa: Vacuum = Field(default=10.0, description="less than this: gone")
    lost_kpa: Vacuum = Field(default=50.0, description="less than this, once confirmed: lost")
    lost_samples: Samples = Field(default=2, description="consecutive samples that lose")
    lost_at_once_kpa: Vacuum = Field(default=20.0, description="less than this, once confirmed: lost at once")
    secure_kpa: Vacuum = Field(default=75.0, description="at least this: a secure grip")
    secure_hysteresis_kpa: Vacuum = Field(
        default=15.0, description="no longer secure this far below secure_kpa"
    )


class CylinderActuator(ActuatorPart):
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


Actuator = Annotated[VacuumActuator | CylinderActuator, Field(discriminator="kind")]
