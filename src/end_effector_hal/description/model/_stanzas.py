"""The stanzas beside those of the actuators: other devices, plain outputs, the wires, what is watched,
refused and proved.
"""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

from pydantic import ConfigDict, Field

from end_effector_hal.kinds.stanza import (
    BaseStanza,
    BelowAmbient,
    ChangerEndings,
    Name,
    Names,
    Opposite,
    Output,
    RosName,
    Samples,
    Seconds,
    Texts,
    Word,
)

from ._channels import LinkFrame


class ToolChanger(Output):
    """The tool changer: its output unlocks while active and locks while inactive.

    The terms are those of the vocabulary ISO 11593.
    """

    opposite: Opposite | None = Field(
        default=None, description="the coil that locks; absent: a spring locks when `line` is inactive"
    )
    locked_bit: Name = Field(default="locked", description="bit that proves locked; none: no such sensor")
    unlocked_bit: Name = Field(
        default="unlocked", description="bit that proves unlocked; none: no such sensor"
    )
    latching: bool = Field(default=False, description="the unlock output may stay active (IL-03 off)")
    unlock_max_s: Seconds = Field(
        default=3.0, description="IL-03: longest time that the unlock output is active"
    )
    prove_s: Seconds = Field(default=2.0, description="IL-04: time limit to prove a lock or unlock")
    proven_s: Seconds = Field(default=0.1, description="IL-04: bits must be steady for this long")
    fault_s: Seconds = Field(
        default=0.5, description="IL-04: both bits or neither for this long: sensor fault"
    )
    vented_kpa: BelowAmbient = Field(
        default=5.0, description="IL-01: unlock only with every vacuum under this"
    )
    vented_s: Seconds = Field(default=0.5, description="IL-01: and for at least this long")
    stand_bit: Name = Field(
        default="in_stand", description="IL-02: bit: the tool is in its stand; none: no such sensor"
    )
    present_bit: Name = Field(
        default="tool_present",
        description="IL-05: bit: there is a tool (asked by IL-02, too); none: no such sensor",
    )
    arm_s: Seconds = Field(
        default=10.0, description="IL-02 without a stand bit: time after `arm` in which an unlock is accepted"
    )
    endings: ChangerEndings = Field(
        default=ChangerEndings.model_construct(), description="what each ending does to the unlock output"
    )
    service: RosName = Field(default="SetToolChanger", description="ROS service")

    BITS: ClassVar = ("locked_bit", "unlocked_bit", "stand_bit", "present_bit")
    """Keys of its sensors."""


class EStop(BaseStanza):
    """An emergency-stop input (IL-13): while it is open, and until a reset, nothing is activated."""

    channel: Name = Field(
        default="estop_ok", description="bit that is set while it is closed; none: no such input"
    )


class Lines(BaseStanza):
    """The access to the output lines."""

    backend: Literal["gpiod", "virtual"] = Field(
        default="gpiod", description="gpiod: the kernel's character device; virtual: a file, no hardware"
    )
    path: Word | None = Field(default=None, description="virtual: the file that is the virtual chip")
    socket: Word | None = Field(
        default=None, description="Unix socket of the line arbiter; default: in the run directory"
    )


class Freshness(BaseStanza):
    """How long a reading is valid."""

    stale_s: Seconds = Field(
        default=0.15, description="a reading is stale after this or stale_periods, the longer"
    )
    stale_periods: Samples = Field(
        default=3, description="periods of its source after which a reading is stale"
    )
    down_s: Seconds = Field(
        default=1.0, description="the link is down after this or down_periods, the longer"
    )
    down_periods: Samples = Field(default=7, description="periods of its source after which the link is down")


class Link(Freshness):
    """The sensor link."""

    def superseded(self) -> tuple[str, ...]:
        """Return ``codec`` if a frame is declared, because then there is no codec."""
        return ("codec",) if self.frame else ()

    port: Word = Field(
        min_length=1, description="serial device, or an address such as tcp://HOST (docs/how-to/network.md)"
    )
    device: Word | None = Field(
        default=None,
        exclude=True,
        description="a sensor of a library of devices that gives the keys which are not written here, and its "
        "channels; beside it `unit` is its address on a bus",
    )
    baudrate: int | None = Field(
        default=None,
        ge=300,
        le=4_000_000,
        description="bits per second; default: that of the codec; of a frame 115200, of Modbus 9600",
    )
    parity: Literal["N", "E", "O"] | None = Field(
        default=None, description="of each byte: none, even, odd; default: that of the codec, of a frame N"
    )
    stopbits: Literal[1, 2] | None = Field(
        default=None,
        description="after each byte; default: 1. Modbus without parity is 2 by its standard, 1 by habit",
    )
    codec: str = Field(
        default="ees1-ascii", min_length=1, description="format of the frames: docs/reference/codecs.md"
    )
    frame: LinkFrame | None = Field(
        default=None, description="format of the frames, declared here instead of `codec`, with `channels`"
    )
    period_ms: Annotated[int | None, Field(ge=1, le=10_000)] = Field(
        default=None,
        description="nominal time between two frames of a declared `frame`; default: 20, of lines that are asked for "
        "100, or the time one frame takes",
    )


Milliseconds = Annotated[int, Field(ge=1, le=10_000)]
MaybeDuration = Annotated[float | None, Field(gt=0, le=3600)]
"""Limit for a whole grip or release, s; it is large because a tool may have 64 steps."""
_COMPUTED = "null: computed from the steps"


class MaintenanceSettings(BaseStanza):
    """Maintenance: the `/Set*` services drive single actuators (IL-12)."""

    lease_s: Seconds = Field(
        default=30.0,
        description="time after the last call until outputs activated by maintenance are deactivated",
    )


class Interlocks(BaseStanza):
    """Interlocks that can be switched off, only here."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, populate_by_name=True)

    il_01: bool = Field(
        default=True, alias="IL-01", description="unlock only when nothing is gripped or held"
    )
    il_02: bool = Field(
        default=True, alias="IL-02", description="unlock only with the tool in its stand or absent, or armed"
    )
    il_05: bool = Field(
        default=True, alias="IL-05", description="no gripping unless the tool is locked and present"
    )
    il_06: bool = Field(
        default=True, alias="IL-06", description="no new grip under the least supply pressure"
    )
    il_07: bool = Field(default=True, alias="IL-07", description="no grip with feedback present or invalid")
    il_09: bool = Field(default=True, alias="IL-09", description="only an explicit Drop releases a held part")


class Bounds(BaseStanza):
    """The limits that the environment keeps and those that the integrator requires; the proof covers both."""

    reaction_ms: Milliseconds = Field(default=50, description="D: longest allowed reaction delay")
    sensor_gap_ms: Milliseconds = Field(default=1, description="least time between two changes of one sensor")
    command_gap_ms: Milliseconds = Field(default=10, description="least time between two commands")
    grip_s: MaybeDuration = Field(default=None, description=f"time limit for a grip; {_COMPUTED}")
    release_s: MaybeDuration = Field(default=None, description=f"time limit for a release; {_COMPUTED}")
    cancel_s: MaybeDuration = Field(
        default=None, description=f"time limit to unwind a cancelled grip; {_COMPUTED}"
    )


class Automata(BaseStanza):
    """The UPPAAL file, and the processes of it that the HAL executes."""

    file: str = Field(
        default="end_effector.xml",
        min_length=1,
        description="relative to the description; default: the shipped one if there is none beside it",
    )
    executed: Texts = Field(
        default=("Gripper", "Actuator", "Changer", "Arming"), description="executed processes"
    )
    interface: Texts = Field(
        default=(
            "evidence",
            "tool",
            "supply_ok",
            "adopted",
            "adopted_part",
            "wanted",
            "adopted_unlock",
            "adopted_fault",
            "adopted_error",
            "vented",
            "parked",
            "ee",
            "valve",
            "changer",
            "changer_fault",
            "unlock_valve",
            "armed",
            "command",
            "actuator",
            "part",
            "kept",
        ),
        description="variables that the executed processes share with the rest",
    )


SAME_FOR_ALL_PARTS = (
    "kind", "device", "line", "pin", "opposite", "on_power_loss", "channel", "frozen_s", "reset_s", "release_s",
    "blow_off", "endings", "service", "topic",
)  # fmt: skip
"""Keys of an actuator that no part may change: its wires, its release, and its names."""
OF_THE_COMMAND = ("command_on",)
"""Keys under ``modbus`` that a part may change."""


class GrippedPart(BaseStanza):
    """A part that the tool grips: which actuators grip it, and with which values."""

    summary: Word = Field(default="", description="a few words, for people")
    uses: Names | None = Field(
        default=None,
        min_length=1,
        description="actuators that grip it; the others stay inactive. Default: the whole sequence",
    )
    actuators: dict[Name, dict[str, Any]] = Field(
        default={},
        description="by name: keys of the actuator that have another value for this part, such as thresholds, "
        "`timeout_s`, `attempts`, `evidence`, and `command_on` under `modbus` (force, speed, position)",
    )


class PlainOutput(Output):
    """An output that any client may switch, except while the e-stop is open (IL-13).

    It is no step of a grip, and never evidence.
    """

    service: RosName | None = Field(default=None, description="ROS service; default: Set + name in CamelCase")
    on_death: Literal["deactivate", "keep"] = Field(
        default="deactivate",
        description="what the line arbiter does when the process that switches it ends or dies",
    )
