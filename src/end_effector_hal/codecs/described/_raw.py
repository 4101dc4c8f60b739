"""Converts the bits of a place on the wire to a raw value, and back."""

from __future__ import annotations

import math
import struct
from typing import NamedTuple

from end_effector_hal.description import mask_shift, raw_limits, type_bits

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
