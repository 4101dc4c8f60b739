"""Frames of channels as a sensor link delivers them, the readings that a detector receives, and their display."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType
from typing import NamedTuple, Protocol, runtime_checkable

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
        inactive: the outputs of a commanded bus that were known to be inactive before these values were requested.
    """

    at: int
    seq: int | None
    device_ms: int | None
    values: Mapping[str, Value]
    inactive: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", MappingProxyType(dict(self.values)))

    def __reduce__(self) -> tuple[type[Frame], tuple[object, ...]]:
        return Frame, (self.at, self.seq, self.device_ms, dict(self.values), self.inactive)


class ChannelReadings(Protocol):
    """The newest reading of each channel, as long as it is fresh and valid."""

    @property
    def fresh(self) -> Mapping[str, int | bool]:
        """The fresh, valid values at the time that is judged, by channel: gauge Pa (vacuum negative), or a bit."""
        ...

    @property
    def carried(self) -> Mapping[str, Kind]:
        """The channels of the codec with their types."""
        ...

    def get(self, channel: str | None, at: int) -> int | bool | None:
        """Return a value at another time, ``at`` µs; None: no fresh, valid reading."""
        ...

    @property
    def arrived(self) -> frozenset[str]:
        """The channels of which the newest frame has a valid value: only that is a sample."""
        ...


class PassingReadings:
    """Readings of one frame that is not stored; other channels come from the stored readings.

    Args:
        remembered: the newest readings before the frame.
        frame: a frame of the same source, soon after them.
    """

    def __init__(self, remembered: ChannelReadings, frame: Frame) -> None:
        valid = {channel: value for channel, value in frame.values.items() if value is not None}
        self.arrived = frozenset(valid)
        for channel in remembered.carried.keys() - valid.keys():  # an invalid value refreshes nothing
            if (value := remembered.get(channel, frame.at)) is not None:
                valid[channel] = value
        self.carried, self.fresh = remembered.carried, valid

    def get(self, channel: str | None, at: int) -> int | bool | None:
        """See `ChannelReadings`."""
        return None if channel is None else self.fresh.get(channel)


class Measure(NamedTuple):
    """The display format of a quantity; values are in thousandths of its unit (Pa for kPa).

    Attributes:
        unit: the unit for people, such as kPa or mm.
        decimals: number of decimals shown.
    """

    unit: str = "kPa"
    decimals: int = 1

    def text(self, value: int) -> str:
        """Return a value, given in thousandths of the unit, as text such as ``-12.3 kPa``."""
        return f"{value / 1000:.{self.decimals}f} {self.unit}"


GAUGE_PRESSURE = Measure()


@runtime_checkable
class MeasuredReadings(Protocol):
    """Readings that include the display format of their channels."""

    @property
    def measures(self) -> Mapping[str, Measure]:
        """Display format by channel; a channel that is not listed is a gauge pressure."""
        ...
