r"""``jaw-line``: ``$SW,<bits>*<crc hex4>\r\n``; bit 0 is ``jaw_closed``, bit 1 ``jaw_open``; CRC-16 as EES1 has it."""

from __future__ import annotations

import re
from binascii import crc_hqx
from collections import Counter
from collections.abc import Mapping
from typing import ClassVar

from end_effector_hal.signals import Frame, Kind

LONGEST = 16
_LINE = re.compile(rb"\$(SW,([0-3]))\*([0-9A-F]{4})\r")


class JawLine:
    """50 lines a second; it counts nothing, so that a lost line is not seen but by the time."""

    name = "jaw-line"
    channels: ClassVar[Mapping[str, Kind]] = {"jaw_closed": Kind.BIT, "jaw_open": Kind.BIT}
    period_us = 20_000
    baudrate = 9_600

    def decoder(self) -> JawLineDecoder:
        """A new one, for one stream."""
        return JawLineDecoder()

    def encode(self, frame: Frame) -> bytes:
        """One line; a missing bit is sent as false."""
        bits = sum(1 << bit for bit, name in enumerate(self.channels) if frame.values.get(name))
        body = b"SW,%d" % bits
        return b"$%s*%04X\r\n" % (body, crc_hqx(body, 0xFFFF))


class JawLineDecoder:
    """Keeps at most the end of an unfinished line."""

    def __init__(self) -> None:
        self.bytes = self.frames = self.lost = self.reboots = 0
        self.errors: Counter[str] = Counter()
        self._rest = b""

    def feed(self, data: bytes, at: int) -> list[Frame]:
        """The frames whose line ends in ``data``."""
        self.bytes += len(data)
        *lines, rest = (self._rest + data).split(b"\n")
        self._rest = rest[-LONGEST:]
        found = [frame for line in lines if (frame := self._frame(line, at))]
        self.frames += len(found)
        return found

    def _frame(self, line: bytes, at: int) -> Frame | None:
        match = _LINE.fullmatch(line[max(line.rfind(b"$"), 0) :])
        if match is None or int(match[3], 16) != crc_hqx(match[1], 0xFFFF):
            self.errors["format" if match is None else "crc"] += 1
            return None
        bits = int(match[2])
        return Frame(
            at, None, None, {name: bool(bits >> bit & 1) for bit, name in enumerate(JawLine.channels)}
        )
