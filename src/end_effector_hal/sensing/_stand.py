"""Where the tool is, by the bits of its stand (IL-02)."""

from __future__ import annotations

from enum import IntEnum

from end_effector_hal.description import ToolChanger

from ._readings import Readings


class ToolPlace(IntEnum):
    """Where the tool is; ``ToolStandPosition`` of the ROS messages."""

    UNKNOWN = 0
    """A bit is stale, invalid, or not carried."""
    IN_STAND = 1
    AWAY = 2
    """On the tool changer, and not in its stand: an unlock would drop it."""
    ABSENT = 3
    """The tool changer carries no tool."""


def tool_place(changer: ToolChanger, readings: Readings, at: int) -> ToolPlace:
    """Where the tool is at ``at`` µs, as far as fresh readings prove it."""
    present, in_stand = readings.get(changer.present_bit, at), readings.get(changer.stand_bit, at)
    if present is not None and not present:
        return ToolPlace.ABSENT
    if in_stand is None or (present is None and changer.present_bit in readings.carried):
        return ToolPlace.UNKNOWN
    return ToolPlace.IN_STAND if in_stand else ToolPlace.AWAY
