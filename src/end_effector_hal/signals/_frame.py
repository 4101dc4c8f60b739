"""Frames of channels, as a sensor link delivers them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType

Value = int | bool | None


class Kind(Enum):
    """The type of a channel's values."""

    PRESSURE = "pressure"
    """Gauge pressure, integer Pa; a vacuum is negative."""
    QUANTITY = "quantity"
    """Another measured quantity (mm, %, V …), integer thousandths of the channel's unit."""
    BIT = "bit"
    """A boolean: a position bit, or a switch in place of a pressure, which means "present"."""
    CODE = "code"
    """A whole number with which a device reports a fault; 0: no fault."""


@dataclass(frozen=True, slots=True)
class Frame:
    """One frame of a link.

    Attributes:
        at: time of its last byte, µs on the monotonic clock of the reader; 0 in a frame that is to be encoded.
        seq: sequence number; None if the codec carries none.
        device_ms: the device's own clock, ms; None if the codec carries none.
        values: by channel, a gauge pressure in Pa, thousandths of another unit, a bit or a code; None: carried, but
            invalid.
    """

    at: int
    seq: int | None
    device_ms: int | None
    values: Mapping[str, Value]

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", MappingProxyType(dict(self.values)))

    def __reduce__(self) -> tuple[type[Frame], tuple[object, ...]]:
        return Frame, (self.at, self.seq, self.device_ms, dict(self.values))
