"""The responding end of Modbus RTU, by the frame table of the standard; it shares no code with the HAL."""

from __future__ import annotations

from typing import NamedTuple

ILLEGAL_VALUE = 3
LONGEST = 256


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
    """One request; ``values`` is None for a read of ``size`` registers or coils."""

    unit: int
    function: int
    address: int
    size: int
    values: tuple[int, ...] | None = None


def read_request(frame: bytes) -> RegisterRequest | None:
    """Parse a complete frame; return None if it is not a request, or damaged."""
    if len(frame) < 8 or len(frame) > LONGEST or crc16(frame[:-2]) != frame[-2:]:
        return None
    unit, function = frame[0], frame[1]
    address, word = int.from_bytes(frame[2:4], "big"), int.from_bytes(frame[4:6], "big")
    if function in (1, 2, 3, 4) and len(frame) == 8:
        return RegisterRequest(unit, function, address, word)
    if function == 6 and len(frame) == 8:
        return RegisterRequest(unit, function, address, 1, (word,))
    if function == 5 and len(frame) == 8 and word in (0, 0xFF00):
        return RegisterRequest(unit, function, address, 1, (int(word == 0xFF00),))
    data = frame[7:-2]
    if function == 16 and frame[6] == 2 * word == len(data):
        words = tuple(int.from_bytes(data[2 * i : 2 * i + 2], "big") for i in range(word))
        return RegisterRequest(unit, function, address, word, words)
    if function == 15 and frame[6] == -(-word // 8) == len(data):
        bits = tuple(data[i // 8] >> i % 8 & 1 for i in range(word))
        return RegisterRequest(unit, function, address, word, bits)
    return None


def done_answer(request: RegisterRequest) -> bytes:
    """Return the answer to a write that was executed."""
    head = bytes([request.unit, request.function]) + request.address.to_bytes(2, "big")
    if request.function == 5:
        return sealed(head + (b"\xff\x00" if request.values == (1,) else b"\x00\x00"))
    if request.function == 6:
        return sealed(head + (request.values or (0,))[0].to_bytes(2, "big"))
    return sealed(head + request.size.to_bytes(2, "big"))


def exception_answer(request: RegisterRequest, code: int) -> bytes:
    """Return the answer to a request that cannot be executed."""
    return sealed(bytes([request.unit, request.function | 0x80, code]))
