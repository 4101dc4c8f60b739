"""Frames of Modbus RTU, by the tables of the standard (V1.1b3); they share no code with the HAL."""

from __future__ import annotations

from typing import NamedTuple

ILLEGAL_FUNCTION, ILLEGAL_ADDRESS, ILLEGAL_VALUE = 1, 2, 3
BROADCAST = 0
LONGEST = 256
READS = (1, 2, 3, 4)
_FIXED = {**dict.fromkeys((1, 2, 3, 4, 5, 6), 8), 22: 10}
"""Bytes of a request by its function, from the unit to the CRC."""
_COUNT_AT = {15: 6, 16: 6, 23: 10}
"""Place of the byte with the number of data bytes."""


def crc16(data: bytes) -> bytes:
    """Return the CRC-16/MODBUS, low byte first."""
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xA001 if crc & 1 else 0)
    return bytes([crc & 0xFF, crc >> 8])


def sealed(body: bytes) -> bytes:
    """Return a frame with its CRC."""
    return body + crc16(body)


class RegisterRequest(NamedTuple):
    """One request.

    Attributes:
        values: what is written; None for a read of ``size`` registers or bits. Function 22: the AND and the OR mask.
        read: address and number of the registers that function 23 reads after its write.
    """

    unit: int
    function: int
    address: int
    size: int
    values: tuple[int, ...] | None = None
    read: tuple[int, int] | None = None


def read_request(frame: bytes) -> RegisterRequest | None:
    """Parse a complete frame; return None if it is not a request, or damaged."""
    if len(frame) < 8 or len(frame) > LONGEST or crc16(frame[:-2]) != frame[-2:]:
        return None
    return parsed(frame[0], frame[1:-2])


def parsed(unit: int, pdu: bytes) -> RegisterRequest | None:
    """Return the request of a PDU; None if its function is unknown, or its length or a value in it is wrong."""
    function, words = pdu[0], _words(pdu[1:5])
    if len(words) < 2:
        return None
    address, word = words
    if function in READS and len(pdu) == 5:
        return RegisterRequest(unit, function, address, word)
    if function == 6 and len(pdu) == 5:
        return RegisterRequest(unit, function, address, 1, (word,))
    if function == 5 and len(pdu) == 5 and word in (0, 0xFF00):
        return RegisterRequest(unit, function, address, 1, (int(word == 0xFF00),))
    if function == 22 and len(pdu) == 7:
        return RegisterRequest(unit, function, address, 1, (word, *_words(pdu[5:7])))
    data = pdu[6:]
    if function == 16 and data and pdu[5] == 2 * word == len(data):
        return RegisterRequest(unit, function, address, word, _words(data))
    if function == 15 and data and pdu[5] == -(-word // 8) == len(data):
        return RegisterRequest(unit, function, address, word, bits_of(data, word))
    if function == 23 and len(pdu) > 10:
        (start, size), data = _words(pdu[5:9]), pdu[10:]
        if pdu[9] == 2 * size == len(data):
            return RegisterRequest(unit, function, start, size, _words(data), read=(address, word))
    return None


def done_answer(request: RegisterRequest) -> bytes:
    """Return the answer to a write that was executed."""
    values = request.values or (0,)
    head = bytes([request.unit, request.function]) + _bytes((request.address,))
    if request.function == 5:
        return sealed(head + (b"\xff\x00" if values == (1,) else b"\x00\x00"))
    if request.function in (6, 22):
        return sealed(head + _bytes(values))
    return sealed(head + _bytes((request.size,)))


def read_answer(request: RegisterRequest, values: tuple[int, ...]) -> bytes:
    """Return the answer to a read, with registers or bits."""
    if request.function in (1, 2):
        data = bytes(
            sum(bit << place for place, bit in enumerate(values[at : at + 8]))
            for at in range(0, len(values), 8)
        )
    else:
        data = _bytes(values)
    return sealed(bytes([request.unit, request.function, len(data)]) + data)


def exception_answer(request: RegisterRequest, code: int) -> bytes:
    """Return the answer to a request that cannot be executed."""
    return refusal(request.unit, request.function, code)


def refusal(unit: int, function: int, code: int) -> bytes:
    """Return an exception response."""
    return sealed(bytes([unit, function | 0x80, code]))


def bits_of(data: bytes, size: int) -> tuple[int, ...]:
    """Return bits that are packed into bytes, the first one lowest."""
    return tuple(data[i // 8] >> i % 8 & 1 for i in range(size))


class FrameReader:
    """Cuts a stream of bytes into frames, as they come from a pty or an adapter.

    The time between two chunks ends a frame (t3.5); within a chunk, which may have lost its pauses, the length of a
    request does. A frame with a wrong CRC is ignored, with all that follows it without a pause.

    Args:
        baudrate: speed of the line, for t3.5; 0: there is no line.
    """

    def __init__(self, baudrate: int) -> None:
        self._silence_us = 38_500_000 // baudrate if 0 < baudrate <= 19_200 else 1750
        self._rest, self._at = b"", 0

    def feed(self, data: bytes, at: int) -> list[bytes]:
        """Return the undamaged frames that end in ``data``, which came at ``at`` (µs)."""
        if at - self._at > self._silence_us:
            self._rest = b""
        self._rest, self._at = (self._rest + data)[-2 * LONGEST :], at
        frames: list[bytes] = []
        while (size := _length(self._rest)) and size <= len(self._rest):
            frame, self._rest = self._rest[:size], self._rest[size:]
            if crc16(frame[:-2]) != frame[-2:]:
                self._rest = b""
                break
            frames.append(frame)
        return frames


def _length(data: bytes) -> int:
    """Return the length of the frame at the beginning; of an unknown function all of it; 0: not known yet."""
    if len(data) < 4:
        return 0
    function = data[1]
    if (place := _COUNT_AT.get(function)) is not None:
        return place + 3 + data[place] if len(data) > place else 0
    return _FIXED.get(function, len(data))


def _words(data: bytes) -> tuple[int, ...]:
    return tuple(int.from_bytes(data[i : i + 2], "big") for i in range(0, len(data) - 1, 2))


def _bytes(words: tuple[int, ...]) -> bytes:
    return b"".join(word.to_bytes(2, "big") for word in words)
