"""From what the sensors show to what a codec carries."""

from __future__ import annotations

from collections.abc import Mapping

from end_effector_hal.description import Description
from end_effector_hal.kinds import kind_of
from end_effector_hal.signals import Kind, Value


def carried(
    values: Mapping[str, Value], channels: Mapping[str, Kind], description: Description
) -> dict[str, Value]:
    """The values that the codec's channels can carry; a pressure on a bit channel becomes "present".

    Args:
        values: channel -> gauge Pa, bit, or None: invalid (of :meth:`Bench.sample`).
        channels: of the codec.
        description: its thresholds are those of the switches.
    """
    seen = {name: values[name] for name in channels if name in values}
    return {name: _as(channels[name], name, value, description) for name, value in seen.items()}


def _as(kind: Kind, channel: str, value: Value, description: Description) -> Value:
    if kind is Kind.PRESSURE or value is None or isinstance(value, bool):
        return value
    return abs(value) >= _present_pa(channel, description)


def _present_pa(channel: str, description: Description) -> float:
    """Where a pressure switch on this channel closes, as a magnitude."""
    for actuator in description.actuators.values():
        if actuator.channel == channel:
            limits = kind_of(actuator).limits(actuator, description.supply)
            if "confirmed_kpa" in limits:
                return limits["confirmed_kpa"] * 1000
    return description.supply.refuse_kpa * 1000
