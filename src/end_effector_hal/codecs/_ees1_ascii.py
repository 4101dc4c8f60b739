r"""``ees1-ascii``: the default format; a line of text with a CRC, readable in any terminal.

``$EES1,<seq>,<t_ms>,<bottom>,<cylinder>,<top>,<supply>,<din hex2>,<status hex2>*<crc hex4>\r\n``,
CRC-16/CCITT-FALSE over the characters between ``$`` and ``*``; pressures are integer Pa gauge, an empty field is
invalid.
"""

from __future__ import annotations

import re
from binascii import crc_hqx

from end_effector_hal.codecs._codec import Decoder
from end_effector_hal.codecs._ees1 import CLOCK_BITS, PRESSURES, SEQ_BITS, Ees1Codec, Ees1Decoder
from end_effector_hal.signals import Frame, Value

LONGEST = 96
_LINE = re.compile(
    rb"\$(?P<body>EES1,([0-9]{1,5}),([0-9]{1,10})" + rb",(-?[0-9]{1,7})?" * 4 + rb",([0-9A-Fa-f]{2})"
    rb",([0-9A-Fa-f]{2}))\*(?P<crc>[0-9A-Fa-f]{4})\r\n"
)


class Ees1Ascii(Ees1Codec):
    """The codec ``ees1-ascii``: four pressures and seven bits, 50 Hz at 115200 baud."""

    name = "ees1-ascii"

    def decoder(self) -> Decoder:
        """Return a new decoder."""
        return Ees1AsciiDecoder()

    def encode(self, frame: Frame) -> bytes:
        """Return one line; ``seq`` and ``device_ms`` wrap around, None counts as 0, a missing bit as false."""
        fields = [self._text(name, frame.values.get(name)) for name in PRESSURES]
        status = sum(1 << bit for bit, text in enumerate(fields) if not text)
        seq, clock = self._head(frame)
        body = f"EES1,{seq},{clock},{','.join(fields)},{self._din(frame):02X},{status:02X}".encode()
        return b"$%s*%04X\r\n" % (body, crc_hqx(body, 0xFFFF))

    def _text(self, name: str, value: Value) -> str:
        return "" if value is None else str(self._pressure(name, value))


class Ees1AsciiDecoder(Ees1Decoder):
    """Keeps at most one unfinished line (96 bytes); every ``$`` starts a new frame, so noise destroys none."""

    def feed(self, data: bytes, at: int) -> list[Frame]:
        """Return the frames that end in ``data``."""
        self.bytes += len(data)
        *lines, rest = (self._rest + data).split(b"\n")
        frames = [frame for line in lines if (frame := self._line(line + b"\n", at))]
        self._rest = self._from_dollar(rest)
        if len(self._rest) > LONGEST:
            self.errors["noise"] += len(self._rest)
            self._rest = b""
        self.frames += len(frames)
        return frames

    def _from_dollar(self, line: bytes) -> bytes:
        """Return what can still be a frame: from the last ``$`` on, because a frame contains no other one."""
        start = line.rfind(b"$")
        noise = len(line) if start < 0 else start
        if noise:
            self.errors["noise"] += noise
        return line[noise:]

    def _line(self, line: bytes, at: int) -> Frame | None:
        line = self._from_dollar(line)
        if not line:
            return None
        match = _LINE.fullmatch(line)
        if match is None:
            self.errors["format"] += 1
            return None
        if int(match["crc"], 16) != crc_hqx(match["body"], 0xFFFF):
            self.errors["crc"] += 1
            return None
        _, seq, clock, *texts, din, status, _ = match.groups()
        if int(seq) >= 1 << SEQ_BITS or int(clock) >= 1 << CLOCK_BITS:
            self.errors["range"] += 1
            return None
        invalid = int(status, 16)
        pressures = [int(text) if text and not invalid >> i & 1 else None for i, text in enumerate(texts)]
        return self._frame(at, int(seq), int(clock), pressures, int(din, 16))
