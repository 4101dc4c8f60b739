"""What the tool watches and refuses, and what is proved about it."""

from __future__ import annotations

from typing import Annotated

from pydantic import ConfigDict, Field

from end_effector_hal.kinds.stanza import Part, Seconds, Texts

Milliseconds = Annotated[int, Field(ge=1, le=10_000)]


class MaintenanceSettings(Part):
    """Actuators driven by hand, with the `/Set*` services (IL-12)."""

    lease_s: Seconds = Field(
        default=30.0, description="so long after the last call what was activated by hand is deactivated"
    )


class Interlocks(Part):
    """Interlocks that can be switched off, here and nowhere else."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, populate_by_name=True)

    il_01: bool = Field(
        default=True, alias="IL-01", description="unlock only when nothing is gripped or held"
    )
    il_02: bool = Field(
        default=True, alias="IL-02", description="unlock only with the tool in its stand or absent, or armed"
    )
    il_05: bool = Field(default=True, alias="IL-05", description="no gripping unless the tool is locked")
    il_06: bool = Field(
        default=True, alias="IL-06", description="no new grip under the least supply pressure"
    )
    il_07: bool = Field(default=True, alias="IL-07", description="no grip with feedback present or invalid")
    il_09: bool = Field(default=True, alias="IL-09", description="only an explicit Drop releases a held part")


class Bounds(Part):
    """What the environment keeps and what the integrator requires; the proof covers it."""

    reaction_ms: Milliseconds = Field(default=50, description="D: longest lateness")
    sensor_gap_ms: Milliseconds = Field(default=1, description="least time between two changes of one sensor")
    command_gap_ms: Milliseconds = Field(default=10, description="least time between two commands")
    message_ms: Milliseconds = Field(default=100, description="the programs hear of each other within")
    grip_s: Seconds = Field(default=58.0, description="every grip is over within")
    release_s: Seconds = Field(default=6.2, description="every release is over within")
    cancel_s: Seconds = Field(default=6.2, description="every cancelled grip is unwound within")


class Automata(Part):
    """The UPPAAL file and which of its processes are executed, by the program that executes them."""

    file: str = Field(
        default="end_effector.xml",
        min_length=1,
        description="relative to the description; default: the shipped one where none stands beside it",
    )
    grip: Texts = Field(
        default=("Gripper", "Actuator"), description="processes that the grip program executes"
    )
    tool_change: Texts = Field(
        default=("Changer", "Arming"), description="processes that the tool-change program executes"
    )
    interface: Texts = Field(
        default=(
            "evidence",
            "tool",
            "supply_ok",
            "adopted",
            "adopted_unlock",
            "adopted_fault",
            "vented",
            "parked",
            "told",
            "ee",
            "valve",
            "changer",
            "changer_fault",
            "unlock_valve",
            "armed",
            "command",
            "actuator",
            "kept",
        ),
        description="variables that the executed processes share with the rest",
    )
