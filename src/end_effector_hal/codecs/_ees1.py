r"""The formats EES1 of the paper's tool: ``ees1-ascii`` and ``ees1-cobs``, with the same channels and bits.

``ees1-ascii`` is the default: a line of text with a CRC, readable in any terminal.
``$EES1,<seq>,<t_ms>,<bottom>,<cylinder>,<top>,<supply>,<din hex2>,<status hex2>*<crc hex4>\r\n``,
CRC-16/CCITT-FALSE over the characters between ``$`` and ``*``; pressures are integer Pa gauge, an empty field is
invalid.

``ees1-cobs`` is the binary form: it needs less than half of the bytes, and detects every loss of bytes.
``00 | COBS(u8 ver=1, u8 type=1, u16 seq, u32 t_ms, i16 x4 in 25 Pa, u8 din, u8 status, u16 crc) | 00``, little
endian, -32768 is invalid; a zero before and after each frame; CRC-16/CCITT-FALSE over all fields before it.
"""

from __future__ import annotations

import re
import struct
from binascii import crc_hqx
from collections import Counter
from collections.abc import Iterable, Mapping
from typing import ClassVar

from cobs import cobs

from end_effector_hal.codecs._codec import CLOCK_BITS, SEQ_BITS, Decoder, Sequence
from end_effector_hal.errors import UsageError
from end_effector_hal.signals import Frame, Kind, Value

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
_LEVELS = [{name: bool(din >> bit & 1) for bit, name in enumerate(BITS)} for din in range(1 << len(BITS))]
# From below the lowest possible vacuum to above any shop-air supply: outside of it a sensor is broken.
LOWEST_PA, HIGHEST_PA = -110_000, 2_000_000


class Ees1Codec:
    """Four pressures and seven bits, 50 Hz at 115200 baud."""

    name: ClassVar[str]
    channels: Mapping[str, Kind] = dict.fromkeys(PRESSURES, Kind.PRESSURE) | dict.fromkeys(BITS, Kind.BIT)
    period_us = 20_000
    baudrate = 115_200

    def _pressure(self, name: str, pascal: int, highest: int = HIGHEST_PA) -> int:
        """Return the pressure in whole Pa; raises UsageError if the format cannot encode it."""
        if not LOWEST_PA <= pascal <= highest:
            raise UsageError(
                f"the pressure {name} = {pascal} Pa does not fit {self.name}",
                todo=f"Give gauge Pa from {LOWEST_PA} to {highest}.",
            )
        return int(pascal)

    def _head(self, frame: Frame) -> tuple[int, int]:
        """Return sequence number and clock, which wrap around; None counts as 0."""
        return (frame.seq or 0) % (1 << SEQ_BITS), (frame.device_ms or 0) % (1 << CLOCK_BITS)

    def _din(self, frame: Frame) -> int:
        """Return the bits as one byte; a missing bit is false."""
        return sum(1 << bit for bit, name in enumerate(BITS) if frame.values.get(name))


class Ees1Decoder:
    """The counters of one stream; subclasses implement the format.

    Attributes:
        bytes, frames: number of bytes fed and of frames returned.
        errors: counts of discarded data, by reason.
    """

    def __init__(self) -> None:
        self.bytes = 0
        self.frames = 0
        self.errors: Counter[str] = Counter()
        self._sequence = Sequence()
        self._rest = b""

    @property
    def lost(self) -> int:
        """Number of frames that are missing according to the sequence numbers."""
        return self._sequence.lost

    @property
    def reboots(self) -> int:
        """Number of reboots of the device, detected by backward jumps."""
        return self._sequence.reboots

    def _frame(
        self, at: int, seq: int, clock: int, pressures: Iterable[int | None], din: int
    ) -> Frame | None:
        """Return the decoded frame; None: its sequence number is repeated (it is counted as duplicate)."""
        if not self._sequence.is_new(seq, clock):
            self.errors["duplicate"] += 1
            return None
        values: dict[str, Value] = dict(zip(PRESSURES, pressures, strict=True))
        for name, pascal in values.items():
            if pascal is not None and not LOWEST_PA <= pascal <= HIGHEST_PA:  # no sensor measures it
                self.errors["range"] += 1
                values[name] = None
        values |= _LEVELS[din % len(_LEVELS)]
        return Frame(at, seq, clock, values)


ASCII_LONGEST = 96
_LINE = re.compile(
    rb"\$(EES1,([0-9]{1,5}),([0-9]{1,10})" + rb",(-?[0-9]{1,7})?" * 4 + rb",([0-9A-Fa-f]{2})"
    rb",([0-9A-Fa-f]{2}))\*([0-9A-Fa-f]{4})\r\n"
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
        self._rest = self._from_dollar(rest) if rest else b""
        if len(self._rest) > ASCII_LONGEST:
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
        match = _LINE.fullmatch(line)
        if match is None:  # noise before it, or no frame
            line = self._from_dollar(line)
            match = _LINE.fullmatch(line)
        if match is None:
            if line:
                self.errors["format"] += 1
            return None
        body, seq, clock, *texts, din, status, crc = match.groups()
        if int(crc, 16) != crc_hqx(body, 0xFFFF):
            self.errors["crc"] += 1
            return None
        if int(seq) >= 1 << SEQ_BITS or int(clock) >= 1 << CLOCK_BITS:
            self.errors["range"] += 1
            return None
        invalid = int(status, 16)
        pressures = [int(text) if text and not invalid >> i & 1 else None for i, text in enumerate(texts)]
        return self._frame(at, int(seq), int(clock), pressures, int(din, 16))


VERSION, TYPE = 1, 1
STEP_PA = 25
INVALID = -32_768
COBS_HIGHEST_PA = 32_767 * STEP_PA
_BODY = struct.Struct("<BBHI4hBB")
_CRC = struct.Struct("<H")
SIZE = _BODY.size + _CRC.size
COBS_LONGEST = SIZE + 1


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
        return INVALID if value is None else round(self._pressure(name, value, COBS_HIGHEST_PA) / STEP_PA)


class Ees1CobsDecoder(Ees1Decoder):
    """Keeps at most one unfinished frame (22 bytes); a zero byte ends any unfinished frame."""

    def feed(self, data: bytes, at: int) -> list[Frame]:
        """Return the frames that end in ``data``."""
        self.bytes += len(data)
        *parts, rest = (self._rest + data).split(b"\0")
        frames = [frame for part in parts if part and (frame := self._part(part, at))]
        # One byte too many is kept: it says that this is no frame, however the bytes came in pieces.
        self._rest = rest[: COBS_LONGEST + 1]
        self.errors["noise"] += len(rest) - len(self._rest)
        self.frames += len(frames)
        return frames

    def _part(self, part: bytes, at: int) -> Frame | None:
        try:
            data = cobs.decode(part) if len(part) <= COBS_LONGEST else b""
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
