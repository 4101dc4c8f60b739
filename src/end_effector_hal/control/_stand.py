"""Where the tool is, by the bits of its stand (IL-02)."""

from __future__ import annotations

from enum import IntEnum

from ._readings import Readings

PRESENT_BIT, STAND_BIT = "tool_present", "in_stand"
"""Channels of the link; a codec need not carry them."""


class ToolPlace(IntEnum):
    """Where the tool is; ``ToolStandPosition`` of the ROS messages."""

    UNKNOWN = 0
    """A bit is stale, invalid, or not carried."""
    IN_STAND = 1
    AWAY = 2
    """On the tool changer, and not in its stand: an unlock would drop it."""
    ABSENT = 3
    """The tool changer carries no tool."""


def tool_place(readings: Readings, at: int) -> ToolPlace:
    """Where the tool is at ``at`` µs, as far as fresh readings prove it."""
    present, in_stand = readings.get(PRESENT_BIT, at), readings.get(STAND_BIT, at)
    if present is not None and not present:
        return ToolPlace.ABSENT
    if in_stand is None or (present is None and PRESENT_BIT in readings.carried):
        return ToolPlace.UNKNOWN
    return ToolPlace.IN_STAND if in_stand else ToolPlace.AWAY
