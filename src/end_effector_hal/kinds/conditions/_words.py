"""What channels show, in words."""

from __future__ import annotations

from collections.abc import Iterable

from end_effector_hal.signals import GAUGE_PRESSURE, ChannelReadings, Measure, MeasuredReadings


def shown(channels: Iterable[str], readings: ChannelReadings, at: int) -> str:
    """``closed is off, cup is at -12.3 kPa``, at ``at`` µs."""
    measures = readings.measures if isinstance(readings, MeasuredReadings) else {}
    return ", ".join(
        f"{channel} {_state(readings.get(channel, at), measures.get(channel, GAUGE_PRESSURE))}"
        for channel in channels
    )


def _state(value: int | bool | None, measure: Measure) -> str:
    if value is None:
        return "has no valid reading"
    if isinstance(value, bool):
        return "is on" if value else "is off"
    return f"is at {measure.text(value)}"
