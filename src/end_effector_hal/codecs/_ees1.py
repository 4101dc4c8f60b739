"""What ``ees1-ascii`` and ``ees1-cobs`` have in common: the channels of EES1 and the order of their bits."""

from __future__ import annotations

from collections.abc import Mapping

from end_effector_hal.errors import UsageError
from end_effector_hal.signals import Kind, Value

PRESSURES = ("bottom", "cylinder", "top", "supply")
BITS = (
    "locked",
    "unlocked",
    "tool_present",
    "in_stand",
    "cylinder_extended",
    "cylinder_retracted",
    "estop_ok",
)
CHANNELS: Mapping[str, Kind] = dict.fromkeys(PRESSURES, Kind.PRESSURE) | dict.fromkeys(BITS, Kind.BIT)
PERIOD_US, BAUDRATE = 20_000, 115_200
SEQ_BITS, CLOCK_BITS = 16, 32
# From below the lowest possible vacuum to above any shop-air supply: outside of it a sensor is broken.
LOWEST_PA, HIGHEST_PA = -110_000, 2_000_000


def din_of(values: Mapping[str, Value]) -> int:
    """The bits as one byte; a missing bit is false."""
    return sum(1 << bit for bit, name in enumerate(BITS) if values.get(name))


def bits_of(din: int) -> dict[str, Value]:
    """The bits of one byte."""
    return {name: bool(din >> bit & 1) for bit, name in enumerate(BITS)}


def check_pressure(codec: str, name: str, pascal: int, highest: int = HIGHEST_PA) -> int:
    """The pressure in whole Pa; raises UsageError if the format cannot carry it."""
    if not LOWEST_PA <= pascal <= highest:
        raise UsageError(
            f"the pressure {name} = {pascal} Pa does not fit {codec}",
            todo=f"Give gauge Pa from {LOWEST_PA} to {highest}.",
        )
    return int(pascal)
