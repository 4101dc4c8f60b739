"""``ees1-cobs``: the binary form of ``ees1-ascii``; less than half of its bytes, and a loss of bytes is always
detected.

``00 | COBS(u8 ver=1, u8 type=1, u16 seq, u32 t_ms, i16 x4 in 25 Pa, u8 din, u8 status, u16 crc) | 00``, little
endian, -32768 is invalid; a zero before and after each frame; CRC-16/CCITT-FALSE over all fields before it.
"""

from __future__ import annotations

import struct
from binascii import crc_hqx

from cobs import cobs

from end_effector_hal.codecs._codec import Decoder
from end_effector_hal.codecs._ees1 import PRESSURES, Ees1Codec, Ees1Decoder
from end_effector_hal.signals import Frame, Value

VERSION, TYPE = 1, 1
STEP_PA = 25
INVALID = -32_768
HIGHEST_PA = 32_767 * STEP_PA
_BODY = struct.Struct("<BBHI4hBB")
_CRC = struct.Struct("<H")
SIZE = _BODY.size + _CRC.size
LONGEST = SIZE + 1


class Ees1Cobs(Ees1Codec):
    """The codec ``ees1-cobs``: four pressures and seven bits, 50 Hz at 115200 baud."""

    name = "ees1-cobs"
    resolution_pa = STEP_PA

    def decoder(self) -> Decoder:
        """Return a new decoder."""
        return Ees1CobsDecoder()

    def encode(self, frame: Frame) -> bytes:
        """Return one frame, pressures rounded to 25 Pa; ``seq`` and ``device_ms`` wrap around, None counts as 0."""
        counts = [self._count(name, frame.values.get(name)) for name in PRESSURES]
        status = sum(1 << bit for bit, count in enumerate(counts) if count == INVALID)
        body = _BODY.pack(VERSION, TYPE, *self._head(frame), *counts, self._din(frame), status)
        return b"\0%s\0" % cobs.encode(body + _CRC.pack(crc_hqx(body, 0xFFFF)))

    def _count(self, name: str, value: Value) -> int:
        return INVALID if value is None else round(self._pressure(name, value, HIGHEST_PA) / STEP_PA)


class Ees1CobsDecoder(Ees1Decoder):
    """Keeps at most one unfinished frame (22 bytes); a zero byte ends any unfinished frame."""

    def feed(self, data: bytes, at: int) -> list[Frame]:
        """Return the frames that end in ``data``."""
        self.bytes += len(data)
        *parts, rest = (self._rest + data).split(b"\0")
        frames = [frame for part in parts if part and (frame := self._part(part, at))]
        # One byte too many is kept: it says that this is no frame, however the bytes came in pieces.
        self._rest = rest[: LONGEST + 1]
        self.errors["noise"] += len(rest) - len(self._rest)
        self.frames += len(frames)
        return frames

    def _part(self, part: bytes, at: int) -> Frame | None:
        try:
            data = cobs.decode(part) if len(part) <= LONGEST else b""
        except cobs.DecodeError:
            data = b""
        body = data[: _BODY.size]
        if len(data) != SIZE or body[:2] != bytes((VERSION, TYPE)):
            self.errors["format"] += 1
            return None
        if _CRC.unpack(data[_BODY.size :]) != (crc_hqx(body, 0xFFFF),):
            self.errors["crc"] += 1
            return None
        _, _, seq, clock, *counts, din, status = _BODY.unpack(body)
        pressures = [
            None if status >> bit & 1 or count == INVALID else count * STEP_PA
            for bit, count in enumerate(counts)
        ]
        return self._frame(at, seq, clock, pressures, din)
