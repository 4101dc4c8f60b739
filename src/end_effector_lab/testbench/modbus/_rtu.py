"""The answering end of Modbus RTU, by the frame table of the standard; it shares no code with the HAL."""

from __future__ import annotations

from typing import NamedTuple, Protocol

ILLEGAL_FUNCTION, ILLEGAL_ADDRESS, ILLEGAL_VALUE = 1, 2, 3
LONGEST = 256


def crc16(data: bytes) -> bytes:
    """CRC-16/MODBUS, low byte first."""
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xA001 if crc & 1 else 0)
    return bytes([crc & 0xFF, crc >> 8])


def sealed(body: bytes) -> bytes:
    """A frame with its CRC."""
    return body + crc16(body)


class RegisterRequest(NamedTuple):
    """One request: ``values`` None: a read of ``size``."""

    unit: int
    function: int
    address: int
    size: int
    values: tuple[int, ...] | None = None


def read_request(frame: bytes) -> RegisterRequest | None:
    """What a whole frame asks for; None: it is no request, or damaged."""
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


def words_answer(request: RegisterRequest, words: list[int]) -> bytes:
    """The answer to a read of registers."""
    data = b"".join(word.to_bytes(2, "big") for word in words)
    return sealed(bytes([request.unit, request.function, len(data)]) + data)


def done_answer(request: RegisterRequest) -> bytes:
    """The answer to a write that was done."""
    head = bytes([request.unit, request.function]) + request.address.to_bytes(2, "big")
    if request.function == 5:
        return sealed(head + (b"\xff\x00" if request.values == (1,) else b"\x00\x00"))
    if request.function == 6:
        return sealed(head + (request.values or (0,))[0].to_bytes(2, "big"))
    return sealed(head + request.size.to_bytes(2, "big"))


def exception_answer(request: RegisterRequest, code: int) -> bytes:
    """The answer to what cannot be done."""
    return sealed(bytes([request.unit, request.function | 0x80, code]))


class RegisterMap(Protocol):
    """The registers of one device; each call comes with its time, µs."""

    def read(self, function: int, address: int, count: int, at: int) -> list[int] | None:
        """Registers; None: it has no such ones."""
        ...

    def write(self, address: int, values: tuple[int, ...], at: int) -> bool:
        """Set registers; False: it has no such ones, or they may not be set so."""
        ...


class RtuServer:
    """Devices on one bus, by their units; others do not answer.

    A request is taken for whole as it comes; half a request is kept until more comes.
    """

    def __init__(self, units: dict[int, RegisterMap]) -> None:
        self._units = units
        self._rest = b""

    def answer(self, data: bytes, at: int) -> bytes:
        """The answer to the request that ends in ``data``, empty where there is none."""
        self._rest = (self._rest + data)[-LONGEST:]
        for start in range(len(self._rest)):
            if (request := read_request(self._rest[start:])) is not None:
                self._rest = b""
                return self._answer(request, at)
        return b""

    def _answer(self, request: RegisterRequest, at: int) -> bytes:
        device = self._units.get(request.unit)
        if device is None:
            return b""
        if request.values is not None:
            done = device.write(request.address, request.values, at)
            return done_answer(request) if done else exception_answer(request, ILLEGAL_ADDRESS)
        if request.function not in (3, 4):
            return exception_answer(request, ILLEGAL_FUNCTION)
        words = device.read(request.function, request.address, request.size, at)
        return exception_answer(request, ILLEGAL_ADDRESS) if words is None else words_answer(request, words)
