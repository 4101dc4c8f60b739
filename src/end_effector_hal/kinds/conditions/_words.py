"""What channels show, in words."""

from __future__ import annotations

from collections.abc import Iterable

from end_effector_hal.signals import ChannelReadings


def shown(channels: Iterable[str], readings: ChannelReadings, at: int) -> str:
    """``closed is off, cup is at -12.3 kPa``, at ``at`` µs."""
    return ", ".join(f"{channel} {_state(readings.get(channel, at))}" for channel in channels)


def _state(value: int | bool | None) -> str:
    if value is None:
        return "has no valid reading"
    if isinstance(value, bool):
        return "is on" if value else "is off"
    return f"is at {value / 1000:.1f} kPa"
