"""What a sensor link delivers: frames of channels."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType

Value = int | bool | None


class Kind(Enum):
    """What a channel carries."""

    PRESSURE = "pressure"
    """Gauge pressure, integer Pa; a vacuum is negative."""
    QUANTITY = "quantity"
    """What else is measured (mm, %, V …), integer thousandths of the channel's unit."""
    BIT = "bit"
    """A boolean: a position bit, or "present" where the channel has the name of a pressure."""
    CODE = "code"
    """A whole number with which a device says what is wrong with it; 0: nothing."""


@dataclass(frozen=True, slots=True)
class Frame:
    """One frame of a link.

    Attributes:
        at: µs of its last byte, on the monotonic clock of the reader; 0 in a frame that is to be encoded.
        seq: sequence number, or None where the codec carries none.
        device_ms: the device's own clock in ms, or None.
        values: channel to gauge pressure in Pa, thousandths of another unit, bit, code, or None: carried, but invalid.
    """

    at: int
    seq: int | None
    device_ms: int | None
    values: Mapping[str, Value]

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", MappingProxyType(dict(self.values)))

    def __reduce__(self) -> tuple[type[Frame], tuple[object, ...]]:
        return Frame, (self.at, self.seq, self.device_ms, dict(self.values))
