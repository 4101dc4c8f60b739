"""The values of declared frames: raw types, checksums, and fields.

A field is one place on the wire, and the channels that are read from it; one number may contain several channels.
"""

from __future__ import annotations

import math
import struct
import zlib
from binascii import crc_hqx
from collections.abc import Callable, Mapping
from functools import cache, reduce
from math import ceil, floor
from operator import xor
from typing import NamedTuple

from end_effector_hal.description import Channel, mask_shift, raw_limits, type_bits
from end_effector_hal.signals import Kind, Value

HIGHEST_FLOAT = 3.4e38


class RawType(NamedTuple):
    """The type of a raw value, with an optional mask that selects some of its bits."""

    value_type: str
    bitmask: int | None = None

    @property
    def bits(self) -> int:
        """Width on the wire, bits."""
        return type_bits(self.value_type)

    @property
    def limits(self) -> tuple[int, int] | None:
        """The lowest and the highest raw value; None: floating point."""
        return raw_limits(self.value_type, self.bitmask)

    @property
    def none(self) -> float | None:
        """The raw value that is not a number (NaN); None: the type has none."""
        return math.nan if self.limits is None else None

    def raw(self, word: int) -> float:
        """Return the raw value of an unsigned number of this width."""
        limits = self.limits
        if limits is None:
            found: float = struct.unpack(">f", word.to_bytes(4, "big"))[0]
            return found
        if self.bitmask is not None:
            word = (word & self.bitmask) >> mask_shift(self.bitmask)
        return word if word <= limits[1] else word - (limits[1] - limits[0] + 1)

    def word(self, raw: float) -> int:
        """Return the bits of a raw value; all other bits are 0."""
        limits = self.limits
        if limits is None:
            low = min(max(raw, -HIGHEST_FLOAT), HIGHEST_FLOAT)
            return int.from_bytes(struct.pack(">f", low), "big")
        word = int(raw) & (limits[1] - limits[0])
        return word << mask_shift(self.bitmask) if self.bitmask is not None else word


class Checksum(NamedTuple):
    """The size of a checksum in bytes, and the function that computes it."""

    size: int
    of: Callable[[bytes], int]


@cache
def _table(polynomial: int, width: int, *, reflected: bool) -> tuple[int, ...]:
    """Return the table of a CRC of this width: the entry of each byte."""
    top, mask = 1 << (width - 1), (1 << width) - 1

    def entry(byte: int) -> int:
        value = byte if reflected else byte << (width - 8)
        for _ in range(8):
            if reflected:
                value = value >> 1 ^ (polynomial if value & 1 else 0)
            else:
                value = (value << 1 ^ (polynomial if value & top else 0)) & mask
        return value

    return tuple(map(entry, range(256)))


def _crc8(data: bytes) -> int:
    table = _table(0x07, 8, reflected=False)
    return reduce(lambda crc, byte: table[crc ^ byte], data, 0)


def _crc16_modbus(data: bytes) -> int:
    table = _table(0xA001, 16, reflected=True)
    return reduce(lambda crc, byte: crc >> 8 ^ table[(crc ^ byte) & 0xFF], data, 0xFFFF)


CHECKSUMS: dict[str, Checksum] = {
    "none": Checksum(0, lambda data: 0),
    "xor8": Checksum(1, lambda data: reduce(xor, data, 0)),
    "sum8": Checksum(1, lambda data: sum(data) & 0xFF),
    "crc8": Checksum(1, _crc8),
    "crc16-modbus": Checksum(2, _crc16_modbus),
    "crc16-ccitt": Checksum(2, lambda data: crc_hqx(data, 0xFFFF)),
    "crc32": Checksum(4, zlib.crc32),
}
"""The checksums by name; crc8 is that of SMBus (07, from 0), crc16-ccitt is CRC-16/CCITT-FALSE (from FFFF),
crc32 that of zlib.
"""


Limits = tuple[int, int] | None


class Field:
    """Converts a raw value to the values of its channels, and back.

    Args:
        channels: the channels by name: one, or several bits with different ``on`` values.
        limits: the lowest and the highest raw value; None: floating point.
    """

    def __init__(self, channels: Mapping[str, Channel], limits: Limits = None) -> None:
        self.channels = dict(channels)
        self._limits = limits
        self.words = frozenset(word for each in channels.values() for word in each.words)

    @property
    def bits(self) -> bool:
        """Whether all channels are bits."""
        return all(channel.kind is Kind.BIT for channel in self.channels.values())

    def values(self, raw: float | str | None) -> dict[str, Value]:
        """Return the values of a raw value; None: there is no raw value."""
        return {name: None if raw is None else each.value(raw) for name, each in self.channels.items()}

    def implausible(self, raw: float | str | None) -> bool:
        """Return whether no sensor can send this raw value; False if it is a declared invalid value."""
        return raw is not None and any(
            raw == raw and raw not in each.invalid and each.value(raw) is None
            for each in self.channels.values()
        )

    def sent(self, values: Mapping[str, Value]) -> float | str | None:
        """Return the raw value or word that a device sends for these values; see `raw`."""
        wanted = {name: values[name] for name in self.channels if name in values}
        if not self.words or not wanted or None in wanted.values():
            return None if self.words else self.raw(values)
        meant = [raw for each in self.channels.values() for raw in (*(each.on or ()), *each.offs)]
        return max(meant, key=lambda raw: self._agreement(raw, wanted))

    def raw(self, values: Mapping[str, Value]) -> float | None:
        """Return the raw value that a device sends for these values; None: the format cannot encode a missing value.

        A value beyond its range is sent as the end of the range, as sensors do; a channel that is missing in
        ``values`` is sent as 0.
        """
        wanted = {name: values[name] for name in self.channels if name in values}
        first = next(iter(self.channels.values()))
        if None in wanted.values() or not wanted:
            raw = self._invalid(first)
            return raw if raw is not None or wanted else self._nearest(first, 0)
        if len(self.channels) == 1:
            (value,) = wanted.values()
            return self._nearest(first, value or 0)
        meant = [raw for each in self.channels.values() for raw in (*(each.on or ()), *(each.off or ()))]
        candidates = [0, 1, *(raw for raw in meant if not isinstance(raw, str))]
        candidates += [value for value in wanted.values() if type(value) is int]  # a code
        candidates += range(len(candidates))
        return float(max(filter(self._fits, candidates), key=lambda raw: self._agreement(raw, wanted)))

    def _agreement(self, raw: float | str, wanted: Mapping[str, Value]) -> int:
        """Return how many channels get their value by a raw value."""
        return sum(self.channels[name].value(raw) == value for name, value in wanted.items())

    def _fits(self, raw: float) -> bool:
        return self._limits is None or self._limits[0] <= raw <= self._limits[1]

    def _invalid(self, channel: Channel) -> float | None:
        """Return a raw value that means "no value": a declared one, or one out of range; None: there is none."""
        if channel.invalid:
            return float(channel.invalid[0])
        if channel.range is None:
            return None
        ends = ((each - channel.offset) / channel.scale for each in channel.range)
        beyond = [raw for end in ends for raw in (floor(end) - 1.0, ceil(end) + 1.0)]
        return next((raw for raw in beyond if self._fits(raw) and channel.value(raw) is None), None)

    def _nearest(self, channel: Channel, value: int | bool) -> float:
        """Return the raw value nearest to this value."""
        raw = channel.raw(value)
        if channel.unit is None:
            return raw
        if channel.range is not None:
            low, high = sorted((each - channel.offset) / channel.scale for each in channel.range)
            raw = min(max(raw, low), high)
        if self._limits is None:
            return raw
        if channel.range is not None and not low <= round(raw) <= high:
            raw = ceil(raw) if ceil(raw) <= high else floor(raw)
        raw = min(max(round(raw), self._limits[0]), self._limits[1])
        near = (each for step in range(len(channel.invalid) + 1) for each in (raw + step, raw - step))
        return float(next((each for each in near if each not in channel.invalid and self._fits(each)), raw))
