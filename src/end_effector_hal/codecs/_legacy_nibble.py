"""``legacy-nibble``: the single byte of the paper's prototype (compatibility only).

One raw byte, 9600 8N1, once a second, no checksum; the high nibble is zero. Bit 3: tool changer unlocked, bit 2:
bottom vacuum, bit 1: cylinder extended, bit 0: top vacuum. Half of all single-bit errors are not detected, and with
feedback once a second a drop is detected too late: use ``ees1-ascii`` if the device can be changed.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

from end_effector_hal.codecs._codec import Decoder
from end_effector_hal.signals import Frame, Kind, Value

_BITS = {"unlocked": 3, "bottom": 2, "cylinder_extended": 1, "top": 0}


class LegacyNibble:
    """The codec ``legacy-nibble``: four booleans; ``locked`` is the complement of ``unlocked``."""

    name = "legacy-nibble"
    channels: Mapping[str, Kind] = dict.fromkeys(("unlocked", "locked", *list(_BITS)[1:]), Kind.BIT)
    period_us = 1_000_000
    baudrate = 9_600

    def decoder(self) -> Decoder:
        """Return a new decoder."""
        return LegacyNibbleDecoder()

    def encode(self, frame: Frame) -> bytes:
        """Return one byte; a missing bit is sent as false, because the format has no invalid value."""
        return bytes([sum(1 << bit for name, bit in _BITS.items() if frame.values.get(name))])


class LegacyNibbleDecoder:
    """Makes a frame of each byte below 16; there is no sequence number, so losses are not detected."""

    def __init__(self) -> None:
        self.bytes = 0
        self.frames = 0
        self.errors: Counter[str] = Counter()
        self.lost = 0
        self.reboots = 0

    def feed(self, data: bytes, at: int) -> list[Frame]:
        """Return a frame for each valid byte."""
        frames = [_frame(byte, at) for byte in data if byte < 16]
        self.bytes += len(data)
        self.frames += len(frames)
        if len(frames) < len(data):
            self.errors["format"] += len(data) - len(frames)
        return frames


def _frame(byte: int, at: int) -> Frame:
    values: dict[str, Value] = {name: bool(byte >> bit & 1) for name, bit in _BITS.items()}
    return Frame(at, None, None, values | {"locked": not values["unlocked"]})
