"""What every tool has: its actuators, their blow-offs, its compressed air, and the watch over a held part."""

from __future__ import annotations

from math import isnan
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from ._base import BaseStanza, Kilopascal, MaybeSeconds, Name, RosName, Seconds, Word
from ._conditions import EvidenceConditions
from ._endings import OwnEndings
from ._line import LineName
from ._output import Output


class Opposite(BaseStanza):
    """The second coil of a valve, which drives the device back."""

    line: LineName = Field(description="name of the GPIO line of that coil")
    pin: Word = Field(default="", description="where it is found on the board; for people")
    pulse_s: Annotated[float | None, Field(ge=0.01, le=2)] = Field(
        default=None,
        description="each coil is active for so long at a change (a bistable valve, a switchable magnet); "
        "null: one of the two is active all the time",
    )
    pause_s: Annotated[float | None, Field(ge=0.05, le=10)] = Field(
        default=None,
        description="after a pulse no coil is active for so long, and a change waits, as for a capacitor that charges "
        "again; null: a change cuts a pulse short",
    )


class Actuator(Output):
    """The keys of every actuator: an output that drives it, a channel that proves it, and its times.

    The output is a `line`, or registers of a Modbus device (`modbus`).

    The stanza of a kind inherits this class, with ``kind: Literal["…"]`` and its own keys. The keys here are also the
    constants of the automata for this actuator: ``timeout_s`` is T_CONFIRM, ``reset_s`` T_RESET, ``release_s`` T_GONE,
    ``attempts`` ATTEMPTS, ``endings`` the …_KEEPS.
    """

    if TYPE_CHECKING:  # a field of each kind's own stanza, where it is one word
        kind: str

    opposite: Opposite | None = Field(
        default=None, description="absent: a spring drives it back when `line` is inactive"
    )
    on_power_loss: Literal["hold", "release", "keep", "undefined"] = Field(
        default="undefined",
        description="without power, by its manual; hold: what is held stays held; keep: it stays as it was",
    )
    channel: Name = Field(description="pressure that proves it; none, where a bit proves it: no such sensor")
    timeout_s: Seconds = Field(
        default=5.0, description="time limit for confirmation; exceeding it is one failed attempt"
    )
    reset_s: Seconds = Field(default=1.0, description="inactive between two attempts")
    attempts: Annotated[int, Field(ge=1, le=20)] = Field(
        default=3, description="failed attempts after which the grip aborts"
    )
    release_s: Seconds = Field(default=2.0, description="longest wait for the feedback to be gone")
    frozen_s: MaybeSeconds = Field(
        default=None,
        description="a pressure that does not move by a count for so long is invalid; null: never",
    )
    evidence: EvidenceConditions | None = Field(
        default=None,
        description="conditions over channels that prove it, instead of what its kind proves; null: as its kind does",
    )
    endings: OwnEndings = Field(
        default=OwnEndings.model_construct(),
        description="what each ending does to this one; default: as for the whole tool",
    )
    service: RosName | None = Field(default=None, description="ROS service; default: Set + name in CamelCase")
    topic: RosName | None = Field(
        default=None, description="ROS topic; default: Pressure + name in CamelCase"
    )


class Supply(BaseStanza):
    """The compressed-air supply (IL-06)."""

    channel: Name = Field(default="supply", description="its pressure; none: no such sensor")
    nominal_kpa: Kilopascal = Field(default=600.0, description="assumed if there is no sensor")
    warn_kpa: Kilopascal = Field(default=450.0, description="less than this: a warning")
    refuse_kpa: Kilopascal = Field(default=400.0, description="less than this: a new grip is refused")
    hysteresis_kpa: Kilopascal = Field(default=20.0, description="granted again this far above refuse_kpa")
    frozen_s: MaybeSeconds = Field(
        default=None,
        description="a pressure that does not move by a count for so long is invalid; null: never",
    )

    def pressure_pa(self, reading: float | None) -> float:
        """Return the reading, gauge Pa, or the nominal pressure if it is missing, invalid or a bit."""
        if reading is None or isinstance(reading, bool) or isnan(reading):
            return self.nominal_kpa * 1000
        return reading


class Hold(BaseStanza):
    """The watch over a held part; it warns, and never releases anything."""

    secure_within_s: Seconds = Field(
        default=2.0, description="a vacuum that is not secure this long after GRIPPED: a weak grip"
    )
    trend_s: Seconds = Field(default=2.0, description="a vacuum is judged over this long for a leak")
    warn_ahead_s: Seconds = Field(
        default=10.0, description="a vacuum that would be lost within this, as it falls now: a leak"
    )
    lift_needs: Literal["confirmed", "secure"] = Field(
        default="confirmed", description="secure: lift_allowed also waits for secure_kpa; else a warning only"
    )


class BlowOff(Output):
    """Compressed air that pushes a part off, never active together with the output that holds it (IL-08).

    With `duration_s` a release blows: after the gap, for this time; the release continues after another gap.
    """

    gap_s: Seconds = Field(
        default=0.05,
        description="IL-08: between the end of suction, or of what else holds, and blowing, and back",
    )
    duration_s: Annotated[float | None, Field(ge=0.05, le=10)] = Field(
        default=None,
        description="a release blows for so long; null: nothing drives it, the line arbiter guards it",
    )
    until_gone: bool = Field(
        default=False,
        description="it ends earlier, as soon as the feedback is gone, and does not begin if it is; with duration_s",
    )
