"""Describes in words what channels show and what conditions require."""

from __future__ import annotations

from collections.abc import Iterable
from math import inf

from end_effector_hal.kinds.stanza import Condition
from end_effector_hal.signals import GAUGE_PRESSURE, ChannelReadings, Measure, MeasuredReadings


def shown(channels: Iterable[str], readings: ChannelReadings, at: int) -> str:
    """Return the readings at ``at`` µs in words, such as ``closed is off, cup is at -12.3 kPa``."""
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


def asked(condition: Condition) -> str:
    """Return what a condition requires, such as ``cup less than 10 kPa, and part off``."""
    if condition.not_ is not None:
        inside = asked(condition.not_)
        return f"{condition.not_.on} off" if condition.not_.on else f"not ({inside})"
    if condition.parts:
        return (", and " if condition.all else ", or ").join(map(asked, condition.parts))
    if condition.on is not None:
        return f"{condition.on} on"
    low, high = condition.span
    unit = " kPa" if (condition.below_kpa, condition.above_kpa, condition.between_kpa) != (None,) * 3 else ""
    limits = (
        f"less than {high:g}"
        if low == -inf
        else f"more than {low:g}"
        if high == inf
        else f"{low:g} to {high:g}"
    )
    return f"{condition.channel} {limits}{unit}"
